//! Builders of bounding volume hierarchies.
//!
//! All see a box by its centroid. A leaf lists its references ascending, so a tree does not tell how the builder's list
//! was rearranged on the way. Where splits would lead deeper than
//! [`MAX_BVH_DEPTH`](restpose_runtime::build::MAX_BVH_DEPTH), the primitives left are parted into equal halves.

mod binned;
mod bins;
mod blocks;
mod depth_limit;
mod grid;
mod hybrid;
mod lane_box;
mod measure;
mod median;
mod primitive;
mod refit;
mod subtree;
mod sweep;
mod sweep_split;
mod top;
mod vertical;

pub use binned::BinnedBvh;
pub use grid::GridBvh;
pub use hybrid::HybridBvh;
pub use median::MedianBvh;
pub use refit::{refit, refit_parallel};
pub use subtree::DEFAULT_LEAF_SIZE;
pub use sweep::SweepBvh;

use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes};

/// Builds a hierarchy; owns all scratch memory, so that a second build of the same size allocates none per box. Builders for
/// many threads make lists of blocks and sub-trees anew.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads or on what was built before.
pub trait BvhBuilder {
    /// Replaces `tree` by the hierarchy over `boxes`. What it promises stands at [`Bvh`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh);
}
