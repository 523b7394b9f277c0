use crate::{
    Aabb,
    build::{KdBuilder, KdSettings, KdTree},
};
use restpose_formats::rows::KdNodeRow;

/// A kd-tree over triangles as they are posed in this frame, world space: for free motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct PosedTree {
    tree: KdTree,
    boxes: Vec<Aabb>,
    /// Triangle row of each box.
    triangles: Vec<u32>,
}

impl PosedTree {
    /// Builds it over `triangles`, posed by `pose`, each once however often it is named. One with a corner that overflowed has no place and hits nothing.
    pub(crate) fn rebuild(&mut self, triangles: &[u32], pose: impl Fn(u32) -> [[f32; 3]; 3], builder: &mut KdBuilder) {
        self.boxes.clear();
        self.triangles.clear();
        self.triangles.extend_from_slice(triangles);
        self.triangles.sort_unstable();
        self.triangles.dedup();
        self.triangles.retain(|triangle| {
            let corners = pose(*triangle);
            let finite = corners.as_flattened().iter().all(|x| x.is_finite());
            if finite {
                self.boxes.push(Aabb::around(corners));
            }
            finite
        });
        builder.build(&self.boxes, &KdSettings::default(), &mut self.tree);
    }

    /// Box around all of them; empty for none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    pub(crate) fn nodes(&self) -> &[KdNodeRow] {
        &self.tree.nodes
    }

    /// Triangle rows in a leaf, by its range of references, each with its box.
    pub(crate) fn leaf(&self, references: std::ops::Range<usize>) -> impl Iterator<Item = (u32, &Aabb)> {
        self.tree.references[references]
            .iter()
            .map(|place| (self.triangles[*place as usize], &self.boxes[*place as usize]))
    }
}
