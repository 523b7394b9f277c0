use crate::{
    Aabb,
    build::{Bvh, BvhContent, BvhSettings, CheckedBoxes, StreamedBvh, finite_box},
    trace::Hierarchy,
    wide::{WideNode, collapse},
};

/// What one task bounds.
#[cfg(feature = "parallel")]
const BOXES_PER_TASK: usize = 1024;

/// A hierarchy in world space over what has boxes in this frame: triangles in free motion, or clusters.
#[derive(Debug, Default)]
pub(crate) struct BoxTree {
    builder: StreamedBvh,
    tree: Bvh,
    boxes: Vec<Aabb>,
    /// What each box is of.
    ids: Vec<u32>,
}

impl BoxTree {
    /// Builds it over `ids`, each of them named once, with the boxes that `bound` tells. What has an empty box is in no
    /// leaf.
    pub(crate) fn rebuild(
        &mut self,
        ids: impl Iterator<Item = u32>,
        bound: impl Fn(u32) -> Aabb + Sync,
        settings: &BvhSettings,
    ) {
        self.ids.clear();
        self.ids.extend(ids);
        self.bound_all(|id| finite_box(&bound(*id)).unwrap_or(Aabb::EMPTY));
        if self.boxes.iter().any(Aabb::is_empty) {
            let mut boxes = self.boxes.iter();
            self.ids
                .retain(|_| boxes.next().is_some_and(|bounds| !bounds.is_empty()));
            self.boxes.retain(|bounds| !bounds.is_empty());
        }
        match CheckedBoxes::new(&self.boxes) {
            Ok(boxes) => self.builder.build(boxes, settings, &mut self.tree),
            // The boxes are finite, and rows of 32 bits count them: there are none.
            Err(_) => self.tree.clear(),
        }
    }

    fn bound_all(&mut self, bound: impl Fn(&u32) -> Aabb + Sync) {
        #[cfg(feature = "parallel")]
        if self.ids.len() > BOXES_PER_TASK {
            use rayon::prelude::*;
            let tasks = self.ids.par_iter().with_min_len(BOXES_PER_TASK);
            tasks.map(&bound).collect_into_vec(&mut self.boxes);
            return;
        }
        self.boxes.clear();
        self.boxes.extend(self.ids.iter().map(&bound));
    }

    /// Box around all of them; empty for none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// How many are in it.
    pub(crate) fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Appends a wide tree over the same ids; where its root is. One without any becomes a root without children.
    pub(crate) fn collapse(&self, nodes: &mut Vec<WideNode>) -> u32 {
        collapse(&self.tree, &self.boxes, |place| self.ids[place as usize], nodes)
    }

    /// What is in a leaf, by its range of references.
    pub(crate) fn leaf(&self, references: std::ops::Range<usize>) -> impl Iterator<Item = u32> {
        self.tree.references[references]
            .iter()
            .map(|place| self.ids[*place as usize])
    }
}

impl Hierarchy for BoxTree {
    #[inline]
    fn bounds(&self, node: u32) -> Aabb {
        self.tree.nodes[node as usize].bounds()
    }

    #[inline]
    fn content(&self, node: u32) -> BvhContent {
        self.tree.nodes[node as usize].content()
    }
}

/// The box around a triangle; empty where a corner overflowed: that one has no place and hits nothing.
#[inline]
pub(crate) fn triangle_box([a, b, c]: [[f32; 3]; 3]) -> Aabb {
    let mut bounds = Aabb { min: a, max: a };
    // A number times zero is zero where it is finite, and else no number.
    let mut zero = 0.0;
    for k in 0..3 {
        bounds.min[k] = least(a[k], least(b[k], c[k]));
        bounds.max[k] = -least(-a[k], least(-b[k], -c[k]));
        zero += a[k] * 0.0 + b[k] * 0.0 + c[k] * 0.0;
    }
    if zero == 0.0 { bounds } else { Aabb::EMPTY }
}

/// Of numbers that compare; [`f32::min`] has to find out.
#[inline]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
