use crate::build::MAX_BVH_DEPTH;
use restpose_formats::rows::{MAX_WIDE_DEPTH, WideChild};

/// Nodes on the longest way down a tree: one per inner node of a binary tree, and where its leaf holds many references,
/// one per halving of these.
pub(super) const MOST_NODES: usize = MAX_BVH_DEPTH + u32::BITS as usize;

const _: () = assert!(MAX_WIDE_DEPTH <= MOST_NODES);

/// Trees that a ray can be in at once: over instances, over the clusters of one or all of its triangles, and over those of a
/// cluster.
pub(crate) const DEPTHS: usize = 3;

/// Each node on the way down leaves seven siblings behind, the last one of a tree eight children.
const SIZE: usize = DEPTHS * (7 * MOST_NODES + 1);

/// Room for the pending children of the trees that a ray is in: children that it meets and that were not looked at yet. What is
/// in it means nothing between traversals: keep it, making it costs more than a ray does.
#[derive(Clone, Debug)]
pub(crate) struct WideStack {
    /// Where the ray enters their boxes.
    enter: Box<[f32; SIZE]>,
    /// What they are, in the walk's own terms.
    tags: Box<[u32; SIZE]>,
}

impl WideStack {
    pub(crate) fn new() -> Self {
        Self {
            enter: zeros(),
            tags: zeros(),
        }
    }

    /// Where the ray enters the child at a place, and its tag.
    #[inline(always)]
    pub(super) fn at(&self, place: usize) -> (f32, u32) {
        (self.enter[place], self.tags[place])
    }

    /// Takes the last of the children above `floor` that the ray enters before `limit`.
    #[inline(always)]
    pub(super) fn pop(&self, count: &mut usize, floor: usize, limit: f32) -> Option<u32> {
        while *count > floor {
            *count -= 1;
            let (enter, child) = self.at(*count);
            if enter <= limit && child != WideChild::EMPTY {
                return Some(child);
            }
        }
        None
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

/// Never on a thread's own stack, which may be small.
fn zeros<T: Clone + Default>() -> Box<[T; SIZE]> {
    match vec![T::default(); SIZE].try_into() {
        Ok(zeros) => zeros,
        Err(_) => unreachable!("there are as many"),
    }
}
