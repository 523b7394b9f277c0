use crate::{
    Aabb,
    build::{Bvh, BvhContent, BvhSettings, CheckedBoxes, StreamedBvh},
    trace::Hierarchy,
};

/// Triangles that one task poses and bounds.
#[cfg(feature = "parallel")]
const TRIANGLES_PER_TASK: usize = 1024;

/// A hierarchy over triangles as they are posed in this frame, world space: for free motion.
#[derive(Debug, Default)]
pub(crate) struct PosedTree {
    builder: StreamedBvh,
    tree: Bvh,
    boxes: Vec<Aabb>,
    /// Triangle of each box.
    triangles: Vec<u32>,
}

impl PosedTree {
    /// Builds it over `triangles`, each of them named once and posed by `pose`. One with a corner that overflowed has no
    /// place and hits nothing.
    pub(crate) fn rebuild(&mut self, triangles: impl Iterator<Item = u32>, pose: impl Fn(u32) -> [[f32; 3]; 3] + Sync) {
        self.triangles.clear();
        self.triangles.extend(triangles);
        let bound = |triangle: &u32| {
            let corners = pose(*triangle);
            let finite = corners.as_flattened().iter().all(|x| x.is_finite());
            if finite { Aabb::around(corners) } else { Aabb::EMPTY }
        };
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let tasks = self.triangles.par_iter().with_min_len(TRIANGLES_PER_TASK);
            tasks.map(bound).collect_into_vec(&mut self.boxes);
        }
        #[cfg(not(feature = "parallel"))]
        {
            self.boxes.clear();
            self.boxes.extend(self.triangles.iter().map(bound));
        }
        if self.boxes.iter().any(Aabb::is_empty) {
            let mut boxes = self.boxes.iter();
            self.triangles
                .retain(|_| boxes.next().is_some_and(|bounds| !bounds.is_empty()));
            self.boxes.retain(|bounds| !bounds.is_empty());
        }
        match CheckedBoxes::new(&self.boxes) {
            Ok(boxes) => self.builder.build(boxes, &BvhSettings::default(), &mut self.tree),
            // The boxes are finite, and rows of 32 bits count them: there are none.
            Err(_) => self.tree.clear(),
        }
    }

    /// Box around all of them; empty for none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// Triangles in a leaf, by its range of references.
    pub(crate) fn leaf(&self, references: std::ops::Range<usize>) -> impl Iterator<Item = u32> {
        self.tree.references[references]
            .iter()
            .map(|place| self.triangles[*place as usize])
    }
}

impl Hierarchy for PosedTree {
    #[inline]
    fn bounds(&self, node: u32) -> Aabb {
        self.tree.nodes[node as usize].bounds()
    }

    #[inline]
    fn content(&self, node: u32) -> BvhContent {
        self.tree.nodes[node as usize].content()
    }
}
