use crate::build::MAX_BVH_DEPTH;
use restpose_formats::rows::MAX_WIDE_DEPTH;

/// Nodes on the longest way down a tree: one per inner node of a binary tree, and where its leaf holds many references,
/// one per halving of these.
pub(super) const MOST_NODES: usize = MAX_BVH_DEPTH + u32::BITS as usize;

const _: () = assert!(MAX_WIDE_DEPTH <= MOST_NODES);

/// Each node on the way down leaves seven siblings behind, the last one eight children.
pub(super) const SIZE: usize = 7 * MOST_NODES + 1;

/// A child that the ray meets and that was not looked at yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    /// Where the ray enters its box.
    pub enter: f32,
    /// The child, packed.
    pub child: u32,
}

/// Room for the pending children of one tree. What is in it means nothing between traversals: keep it, making it costs
/// more than a ray does.
#[derive(Clone, Debug)]
pub(crate) struct WideStack(pub(super) [Pending; SIZE]);

impl WideStack {
    pub(crate) const fn new() -> Self {
        Self([Pending { enter: 0.0, child: 0 }; SIZE])
    }
}
