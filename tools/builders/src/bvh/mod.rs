//! Builders of bounding volume hierarchies.
//!
//! All see a box by its centroid. A hierarchy is a function of the boxes: a leaf lists its references ascending, however
//! the builder's list was rearranged on the way.

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

/// Builds a hierarchy; owns all scratch memory, so that a second build of the same size allocates none.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads or on what was built before.
pub trait BvhBuilder {
    /// Replaces `tree` by the hierarchy over `boxes`. What it promises stands at [`Bvh`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh);
}
