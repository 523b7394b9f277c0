//! Builders of kd-trees.

mod axis_sides;
mod bins;
mod cell_cost;
mod cut;
mod float_order;
mod fragment;
mod growth;
mod kalman;
mod line_search;
mod plane_search;
mod rank_counts;
mod ranked;
mod ranked_fragment;
mod streamed;
mod streamed_top;
mod subtree;
mod tracked;
mod tracking_stats;

use restpose_runtime::build::{CheckedBoxes, KdBuilder, KdSettings, KdTree};

pub use streamed::StreamedKd;
pub use tracked::TrackedKd;
pub use tracking_stats::TrackingStats;

/// Builds a kd-tree; owns all scratch memory.
pub trait KdTreeBuilder {
    /// Replaces `tree` by the tree over `boxes`. What it promises stands at [`KdTree`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &KdSettings, tree: &mut KdTree);
}

impl KdTreeBuilder for KdBuilder {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &KdSettings, tree: &mut KdTree) {
        Self::build(self, boxes.get(), settings, tree);
    }
}
