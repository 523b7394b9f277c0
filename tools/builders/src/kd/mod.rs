//! Builders of kd-trees.

mod bins;
mod cell_cost;
mod cut;
mod fragment;
mod growth;
mod ranked;
mod streamed;
mod streamed_top;
mod subtree;

use restpose_runtime::build::{CheckedBoxes, KdBuilder, KdSettings, KdTree};
pub use streamed::StreamedKd;

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
