use crate::atomic::{
    AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

/// Vertices of an instance that rays have posed in this frame, so that each is posed once, whichever ray comes first.
///
/// Threads share it without waiting: whoever finds a vertex missing poses it and writes it down; all write the same bits.
/// A reader takes a position only behind its frame's stamp, which is written last.
#[derive(Debug, Default)]
pub(crate) struct VertexMemo {
    /// Three coordinates and the frame that they belong to, per vertex.
    rows: Vec<[AtomicU32; 4]>,
    /// The present frame; 0 is none.
    pub(crate) frame: u32,
}

impl VertexMemo {
    /// Begins a pose: no vertex is posed yet.
    pub(crate) fn begin(&mut self, vertices: usize) {
        self.rows.resize_with(vertices, Default::default);
        self.frame = self.frame.wrapping_add(1);
        if self.frame == 0 {
            // Stamps of 2³² frames ago would be taken for new ones.
            self.rows.fill_with(Default::default);
            self.frame = 1;
        }
    }

    /// What [`Self::position`] reads and [`Self::keep`] writes.
    #[inline]
    pub(crate) fn row(&self, vertex: u32) -> &[AtomicU32; 4] {
        &self.rows[vertex as usize]
    }

    /// A vertex's position in this frame, where somebody has posed it.
    #[inline]
    pub(crate) fn position(&self, vertex: u32) -> Option<[f32; 3]> {
        let [x, y, z, frame] = self.row(vertex);
        (frame.load(Acquire) == self.frame)
            .then(|| [x, y, z].map(|coordinate| f32::from_bits(coordinate.load(Relaxed))))
    }

    /// Writes down a vertex's position in this frame. Whoever does so for the same vertex has the same one.
    #[inline]
    pub(crate) fn keep(&self, vertex: u32, position: [f32; 3]) {
        let [x, y, z, frame] = self.row(vertex);
        for (place, coordinate) in [x, y, z].into_iter().zip(position) {
            place.store(coordinate.to_bits(), Relaxed);
        }
        frame.store(self.frame, Release);
    }
}
