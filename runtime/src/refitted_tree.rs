use crate::{Aabb, build::BvhContent, trace::Hierarchy};
use restpose_formats::rows::{KdNode, KdNodeRow};
use std::sync::{
    Mutex, OnceLock, PoisonError,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// World boxes over the nodes of a fuzzy tree, where its cluster's own space is of no use in a frame: the topology is kept,
/// its triangles are posed, and every node gets the box of what is below it. A tree of boxes, no longer a kd-tree: each
/// triangle counts in the first leaf that references it, so that siblings overlap by no more than triangles do.
///
/// Made when a ray needs it, then kept for the frame. Threads that come at the same time wait for it.
#[derive(Debug, Default)]
pub(crate) struct RefittedTree {
    boxes: OnceLock<Vec<Aabb>>,
    /// Rays that entered the cluster in this frame, where they are counted.
    entered: AtomicU32,
    /// Memory of an earlier frame.
    spare: Mutex<Vec<Aabb>>,
}

impl RefittedTree {
    /// Begins a frame.
    pub(crate) fn forget(&mut self) {
        if let Some(boxes) = self.boxes.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = boxes;
        }
        *self.entered.get_mut() = 0;
    }

    /// Counts a ray that enters the cluster; true when as many as `rays` have done so before.
    pub(crate) fn is_worth_it(&self, rays: u32) -> bool {
        // One ray more or less changes no hit.
        self.boxes.get().is_some() || self.entered.fetch_add(1, Relaxed) >= rays
    }

    /// The boxes of the cluster's nodes. `references` are its triangle rows, `first` says of each whether it is its
    /// triangle's first.
    pub(crate) fn boxes(
        &self,
        nodes: &[KdNodeRow],
        references: &[u32],
        first: &[bool],
        pose: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> &[Aabb] {
        self.boxes.get_or_init(|| {
            let mut boxes = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
            refit(nodes, references, first, pose, &mut boxes);
            boxes
        })
    }
}

/// A refitted tree, as a hierarchy.
pub(crate) struct RefittedBoxes<'a> {
    pub nodes: &'a [KdNodeRow],
    pub boxes: &'a [Aabb],
}

impl Hierarchy for RefittedBoxes<'_> {
    #[inline]
    fn bounds(&self, node: u32) -> Aabb {
        self.boxes[node as usize]
    }

    #[inline]
    fn content(&self, node: u32) -> BvhContent {
        match self.nodes[node as usize].unpack() {
            KdNode::Inner { left, .. } => BvhContent::Inner { left },
            KdNode::Leaf { first, count } => BvhContent::Leaf { first, count },
        }
    }
}

fn refit(
    nodes: &[KdNodeRow],
    references: &[u32],
    first: &[bool],
    pose: impl Fn(u32) -> [[f32; 3]; 3],
    boxes: &mut Vec<Aabb>,
) {
    boxes.clear();
    boxes.resize(nodes.len(), Aabb::EMPTY);
    // Children stand behind their parents.
    for (at, node) in nodes.iter().enumerate().rev() {
        boxes[at] = match node.unpack() {
            KdNode::Inner { left, .. } => boxes[left as usize].union(boxes[left as usize + 1]),
            KdNode::Leaf { first: begin, count } => {
                let leaf = begin as usize..begin as usize + count as usize;
                let own = references[leaf.clone()].iter().zip(&first[leaf]);
                let corners = own
                    .filter(|(_, first)| **first)
                    .flat_map(|(triangle, _)| pose(*triangle));
                // Vertices that overflowed have no place, and their triangles hit nothing.
                Aabb::around(corners.filter(|corner| corner.iter().all(|x| x.is_finite())))
            }
        };
    }
}
