//! Builders of kd-trees.

use restpose_runtime::build::{CheckedBoxes, KdSettings, KdTree};

/// Builds a kd-tree; owns all scratch memory.
pub trait KdTreeBuilder {
    /// Replaces `tree` by the tree over `boxes`. What it promises stands at [`KdTree`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &KdSettings, tree: &mut KdTree);
}
