//! Builders that make use of the frame before, a line each.

use super::tree::{Tree, TreeKind};
use crate::MeasureError;
use restpose_builders::bvh::{BvhBuilder, HybridBvh, refit};
use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes};

/// A builder for one frame after the other.
pub(super) struct Follower {
    pub name: &'static str,
    pub kind: TreeKind,
    /// One that has seen no frame.
    pub make: fn() -> Box<dyn FrameWorker>,
}

/// It at work.
pub(super) trait FrameWorker: Send {
    /// Builds for the next frame; what is timed.
    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError>;

    /// A copy of the tree that was built last.
    fn tree(&self) -> Tree;

    /// How well it foresaw the last frame, if it tries to.
    fn foresight(&self) -> Option<Foresight> {
        None
    }
}

/// How well a frame's split planes were foreseen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Foresight {
    /// Share of the nodes whose plane was foreseen at all.
    pub tracked_fraction: f64,
    /// Mean distance of a foreseen plane from the best, relative to its cell.
    pub prediction_error: f64,
    /// Mean evaluations of the cost in search of a plane that was foreseen.
    pub tracked_steps: f64,
    /// The same where it was not.
    pub untracked_steps: f64,
}

/// All of them.
pub(super) fn followers() -> Vec<Follower> {
    vec![Follower {
        name: "bvh-refit",
        kind: TreeKind::Bvh,
        make: || Box::new(Refit(Bvh::default())),
    }]
}

/// The topology of the first frame, by the binned builder, in all frames.
struct Refit(Bvh);

impl FrameWorker for Refit {
    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        if self.0.nodes.is_empty() {
            HybridBvh::default().build(boxes, &BvhSettings::default(), &mut self.0);
            return Ok(());
        }
        Ok(refit(&mut self.0, boxes)?)
    }

    fn tree(&self) -> Tree {
        Tree::Bvh(self.0.clone())
    }
}
