use crate::build::MAX_BVH_DEPTH;
use restpose_formats::rows::MAX_WIDE_DEPTH;

/// Nodes on the longest way down a tree: one per inner node of a binary tree, and where its leaf holds many references,
/// one per halving of these.
pub(super) const MOST_NODES: usize = MAX_BVH_DEPTH + u32::BITS as usize;

const _: () = assert!(MAX_WIDE_DEPTH <= MOST_NODES);

/// Each node on the way down leaves seven siblings behind, the last one eight children.
pub(super) const SIZE: usize = 7 * MOST_NODES + 1;

/// Room for the pending children of one tree: children that the ray meets and that were not looked at yet. What is in it means
/// nothing between traversals: keep it, making it costs more than a ray does.
#[derive(Clone, Debug)]
pub(crate) struct WideStack {
    /// Where the ray enters their boxes.
    enter: [f32; SIZE],
    /// What they are, in the walk's own terms.
    tags: [u32; SIZE],
}

impl WideStack {
    pub(crate) const fn new() -> Self {
        Self {
            enter: [0.0; SIZE],
            tags: [0; SIZE],
        }
    }

    /// Where the ray enters the child at a place, and its tag.
    #[inline(always)]
    pub(super) fn at(&self, place: usize) -> (f32, u32) {
        (self.enter[place], self.tags[place])
    }

    /// Eight places from `first` on.
    #[inline(always)]
    pub(super) fn eight(&mut self, first: usize) -> (&mut [f32; 8], &mut [u32; 8]) {
        let enter = self.enter[first..].first_chunk_mut();
        let tags = self.tags[first..].first_chunk_mut();
        match (enter, tags) {
            (Some(enter), Some(tags)) => (enter, tags),
            _ => unreachable!("a tree is no deeper than the stack"),
        }
    }
}
