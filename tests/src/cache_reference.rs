//! An independent reading of vertex caches, OBJ with PC2 or MDD or a row of OBJ files: where every vertex is at a time.
//!
//! Source: Wavefront, *Object Files (.obj)*, Advanced Visualizer manual, appendix B1; the PC2 and MDD layouts are in
//! [`point_cache`]. Written from those alone; it shares no code with the baker or the runtime, for it is what their
//! vertices are measured against.
//!
//! It is test code: a file that it cannot read makes it panic and say why.

mod obj;
mod point_cache;
#[cfg(test)]
mod tests;

pub use obj::{Obj, ObjFace};
use std::path::Path;

/// Frames per second where neither the file nor the caller says.
pub const DEFAULT_FRAMES_PER_SECOND: f64 = 24.0;

/// A decoded vertex cache that can be evaluated at any time.
#[derive(Clone, Debug)]
pub struct CacheReference {
    obj: Obj,
    /// Strictly increasing, one per frame.
    seconds: Vec<f64>,
    /// `[frame][vertex]`, vertices by the OBJ's numbering from 0.
    frames: Vec<Vec<[f32; 3]>>,
}

impl CacheReference {
    /// Reads an OBJ and the PC2 or MDD file that moves it.
    ///
    /// # Panics
    /// When a file cannot be read or breaks its format.
    pub fn load(obj: &Path, cache: &Path, frames_per_second: Option<f64>) -> Self {
        let read = |path: &Path| std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self::from_bytes(&read(obj), &read(cache), frames_per_second)
    }

    /// Decodes the bytes of an OBJ and of a PC2 or MDD file; the latter two are told apart by PC2's magic word.
    ///
    /// # Panics
    /// When the bytes break their format, or the cache has another number of points than the OBJ has vertices.
    pub fn from_bytes(obj: &[u8], cache: &[u8], frames_per_second: Option<f64>) -> Self {
        let obj = Obj::parse(obj);
        let (seconds, frames) = if cache.starts_with(point_cache::PC2_MAGIC) {
            point_cache::pc2(cache, frames_per_second.unwrap_or(DEFAULT_FRAMES_PER_SECOND))
        } else {
            point_cache::mdd(cache, frames_per_second)
        };
        Self::new(obj, seconds, frames)
    }

    /// Decodes a row of OBJ files, one per frame, the first at 0 seconds; faces are those of the first.
    ///
    /// # Panics
    /// When there is none, one breaks its format, or one has other faces than the first.
    pub fn from_obj_row(files: &[&[u8]], frames_per_second: Option<f64>) -> Self {
        let rate = frames_per_second.unwrap_or(DEFAULT_FRAMES_PER_SECOND);
        let objs: Vec<Obj> = files.iter().map(|file| Obj::parse(file)).collect();
        let first = objs.first().expect("a file").clone();
        for (frame, obj) in objs.iter().enumerate() {
            let faces = obj.faces.iter().map(|face| &face.corners);
            assert!(
                faces.eq(first.faces.iter().map(|face| &face.corners)),
                "the faces of frame {frame}"
            );
        }
        let seconds = (0..objs.len()).map(|frame| frame as f64 / rate).collect();
        let frames = objs.into_iter().map(|obj| obj.positions).collect();
        Self::new(first, seconds, frames)
    }

    fn new(obj: Obj, seconds: Vec<f64>, frames: Vec<Vec<[f32; 3]>>) -> Self {
        assert!(!frames.is_empty(), "no frames");
        assert!(seconds.is_sorted_by(|a, b| a < b), "times do not increase: {seconds:?}");
        for (frame, points) in frames.iter().enumerate() {
            assert_eq!(points.len(), obj.positions.len(), "points of frame {frame}");
        }
        Self { obj, seconds, frames }
    }

    /// The OBJ: faces and the positions that it states itself.
    pub fn obj(&self) -> &Obj {
        &self.obj
    }

    /// Seconds of each frame.
    pub fn frame_seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// The vertices of one frame as stored, by the OBJ's numbering from 0.
    ///
    /// # Panics
    /// When there is no such frame.
    pub fn frame(&self, frame: usize) -> &[[f32; 3]] {
        &self.frames[frame]
    }

    /// Every vertex of the OBJ at a time: linear between frames, the first frame before it, the last frame after it.
    ///
    /// Space: the OBJ's, scene units, f64.
    pub fn positions(&self, seconds: f64) -> Vec<[f64; 3]> {
        let last = self.frames.len() - 1;
        let next = self.seconds.iter().position(|frame| *frame > seconds);
        let (from, to, along) = match next {
            Some(0) => (0, 0, 0.0),
            None => (last, last, 0.0),
            Some(next) => {
                let (before, after) = (self.seconds[next - 1], self.seconds[next]);
                (next - 1, next, (seconds - before) / (after - before))
            }
        };
        let blend = |axis: usize, (a, b): (&[f32; 3], &[f32; 3])| {
            (1.0 - along) * f64::from(a[axis]) + along * f64::from(b[axis])
        };
        let pairs = self.frames[from].iter().zip(&self.frames[to]);
        pairs
            .map(|pair| std::array::from_fn(|axis| blend(axis, pair)))
            .collect()
    }
}
