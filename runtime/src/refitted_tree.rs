use crate::{
    Aabb,
    box_tree::triangle_box,
    build::BvhContent,
    trace::Hierarchy,
    wide::{WideNode, append_rows, refit},
};
use restpose_formats::rows::{KdNode, KdNodeRow, WideChild, WideNodeRow};
use std::sync::{
    Mutex, OnceLock, PoisonError,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// World boxes over the nodes of a fuzzy tree, where its cluster's own space is of no use in a pose: the topology is kept,
/// its triangles are posed, and every node gets the box of what is below it. Of a kd-tree that makes a hierarchy of boxes:
/// each triangle counts in the first leaf that references it, so that siblings overlap by no more than triangles do.
///
/// Made when a ray needs it, then kept for the pose. Threads that come at the same time wait for it.
#[derive(Debug, Default)]
pub(crate) struct RefittedTree {
    nodes: OnceLock<RefittedNodes>,
    /// Rays that entered the cluster in this pose, where they are counted.
    entered: AtomicU32,
    /// Memory of an earlier pose.
    spare: Mutex<RefittedNodes>,
}

/// One of the two is in use: the file's kind of tree says which.
#[derive(Debug, Default)]
struct RefittedNodes {
    /// A box per kd node.
    boxes: Vec<Aabb>,
    wide: Vec<WideNode>,
}

impl RefittedTree {
    /// Begins a pose.
    pub(crate) fn forget(&mut self) {
        if let Some(nodes) = self.nodes.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = nodes;
        }
        *self.entered.get_mut() = 0;
    }

    /// Counts rays that enter the cluster, so many `entering` now; true when as many as `rays` have done so before.
    pub(crate) fn is_worth_it(&self, rays: u32, entering: u32) -> bool {
        // One ray more or less changes no hit.
        self.nodes.get().is_some() || self.entered.fetch_add(entering, Relaxed) >= rays
    }

    /// The boxes of the nodes of a cluster's kd-tree. `references` are its triangle rows, `first` says of each whether it is
    /// its triangle's first.
    pub(crate) fn boxes(
        &self,
        nodes: &[KdNodeRow],
        references: &[u32],
        first: &[bool],
        pose: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> &[Aabb] {
        &self
            .made(|made| refit_kd(nodes, references, first, pose, &mut made.boxes))
            .boxes
    }

    /// A cluster's wide tree in world space.
    pub(crate) fn wide(&self, rows: &[WideNodeRow], pose: impl Fn(u32) -> [[f32; 3]; 3]) -> &[WideNode] {
        let made = self.made(|made| {
            made.wide.clear();
            append_rows(&mut made.wide, rows, WideChild::Leaf);
            refit(&mut made.wide, |triangle| triangle_box(pose(triangle)));
        });
        &made.wide
    }

    fn made(&self, make: impl FnOnce(&mut RefittedNodes)) -> &RefittedNodes {
        self.nodes.get_or_init(|| {
            let mut nodes = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
            make(&mut nodes);
            nodes
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

fn refit_kd(
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
