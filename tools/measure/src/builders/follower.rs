//! Builders that make use of the frame before, a line each.

use super::tree::{Tree, TreeKind};
use crate::MeasureError;
use restpose_builders::{
    bvh::{BvhBuilder, HybridBvh, refit},
    kd::{KdTreeBuilder, TrackedKd, TrackingStats},
};
use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes, KdSettings, KdTree};

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

    /// How well it foresaw the planes of the last frame, if it tries to.
    fn tracking(&self) -> Option<TrackingStats> {
        None
    }
}

/// All of them.
pub(super) fn followers() -> Vec<Follower> {
    let follower = |name, kind, make| Follower { name, kind, make };
    vec![
        follower("bvh-refit", TreeKind::Bvh, || Box::new(Refit(Bvh::default()))),
        follower("kd-tracked", TreeKind::Kd, || tracked(TrackedKd::new())),
        follower("kd-tracked-paper", TreeKind::Kd, || tracked(TrackedKd::paper())),
    ]
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

/// Planes tracked from frame to frame.
struct Tracked {
    builder: TrackedKd,
    tree: KdTree,
}

fn tracked(builder: TrackedKd) -> Box<dyn FrameWorker> {
    let tree = KdTree::default();
    Box::new(Tracked { builder, tree })
}

impl FrameWorker for Tracked {
    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        self.builder.build(boxes, &KdSettings::default(), &mut self.tree);
        Ok(())
    }

    fn tree(&self) -> Tree {
        Tree::Kd(self.tree.clone())
    }

    fn tracking(&self) -> Option<TrackingStats> {
        Some(*self.builder.stats())
    }
}
