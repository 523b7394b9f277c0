//! Builders of bounding volume hierarchies.

use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes};

/// Builds a hierarchy; owns all scratch memory, so that a second build of the same size allocates none.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads or on what was built before.
pub trait BvhBuilder {
    /// Replaces `tree` by the hierarchy over `boxes`. What it promises stands at [`Bvh`]. Ends on any boxes and settings.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh);
}
