//! Builders of bounding volume hierarchies.
//!
//! All see a box by its centroid. But for [`StreamedBvh`], a leaf lists its references ascending, so a tree does not tell
//! how the builder's list was rearranged on the way, and where splits would lead deeper than
//! [`MAX_BVH_DEPTH`](restpose_runtime::build::MAX_BVH_DEPTH), the primitives left are parted into equal halves by their
//! centroids.

mod binned;
mod bins;
mod blocks;
mod depth_limit;
mod fused;
mod fused_bins;
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
mod wide;

pub use binned::BinnedBvh;
pub use fused::FusedBvh;
pub use grid::GridBvh;
pub use hybrid::HybridBvh;
pub use median::MedianBvh;
pub use refit::{refit, refit_parallel};
pub use subtree::DEFAULT_LEAF_SIZE;
pub use sweep::SweepBvh;
pub use wide::{TooManyBoxes, WideBuilder, WideBvh, WideFault};

use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes, StreamedBvh};

/// Builds a hierarchy; owns all scratch memory, so that a second build of the same size allocates none per box. Builders for
/// many threads make lists of blocks and sub-trees anew.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads or on what was built before.
pub trait BvhBuilder {
    /// Replaces `tree` by the hierarchy over `boxes`. What it promises stands at [`Bvh`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh);
}

/// Leaves list their references as the build left them.
impl BvhBuilder for StreamedBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        StreamedBvh::build(self, boxes, settings, tree);
    }
}
