//! Builders of trees over boxes, and the cost model that they minimise.
//!
//! [`KdBuilder`] is the exact sweep, which the baker runs once per cluster over fuzzy boxes. [`StreamedBvh`] runs in every
//! frame, over the clusters' world boxes and over what moves freely. [`KdTree`] says what a tree promises and checks it,
//! [`sah_cost`] says how good one is; [`Bvh`] does both for hierarchies. Builders over geometry take [`CheckedBoxes`].

mod both;
mod bvh;
mod bvh_bins;
mod bvh_eight;
mod bvh_extent;
mod bvh_few;
mod bvh_large;
mod bvh_primitive;
mod bvh_split;
mod bvh_streamed;
mod bvh_subtree;
#[cfg(feature = "parallel")]
mod bvh_tasks;
mod bvh_validate;
mod checked_boxes;
mod finite_box;
mod kd_event;
mod kd_split;
mod kd_sweep;
mod kd_tree;
mod kd_validate;
mod sah;
#[cfg(test)]
mod tests;

pub use bvh::{Bvh, BvhContent, BvhNode, BvhSettings, MAX_BVH_DEPTH};
pub use bvh_bins::BinCount;
pub use bvh_streamed::StreamedBvh;
pub use bvh_validate::BvhFault;
pub use checked_boxes::{BuildError, CheckedBoxes};
pub(crate) use finite_box::finite_box;
pub use kd_sweep::{KdBuilder, MAX_REFERENCE_GROWTH};
pub use kd_tree::KdTree;
pub use kd_validate::KdFault;
pub use sah::{KdSettings, sah_cost};
