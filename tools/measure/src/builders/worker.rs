use super::tree::Tree;
use crate::MeasureError;
use restpose_builders::{
    bvh::{BvhBuilder, HybridBvh, refit_parallel},
    kd::KdTreeBuilder,
};
use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes, KdSettings, KdTree};

/// A builder at work: its scratch memory and the tree that it built last.
pub(super) trait Worker: Send {
    /// Makes ready what is no part of a build, such as the boxes in a peer's own form. Not timed.
    fn prepare(&mut self, _boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        Ok(())
    }

    /// Builds; what is timed.
    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError>;

    /// The tree that was built last, in the runtime's form. Not timed; the worker keeps none.
    fn take_tree(&mut self) -> Result<Tree, MeasureError>;
}

/// Builds hierarchies by `build`, which owns its scratch memory.
pub(super) fn bvh_worker(
    mut build: impl FnMut(CheckedBoxes<'_>, &BvhSettings, &mut Bvh) + Send + 'static,
) -> Box<dyn Worker> {
    Box::new(Own {
        build: move |boxes: CheckedBoxes<'_>, tree: &mut Bvh| build(boxes, &BvhSettings::default(), tree),
        tree: Bvh::default(),
        wrap: Tree::Bvh,
    })
}

/// A builder of kd-trees.
pub(super) fn kd_worker(mut builder: impl KdTreeBuilder + Send + 'static) -> Box<dyn Worker> {
    Box::new(Own {
        build: move |boxes: CheckedBoxes<'_>, tree: &mut KdTree| builder.build(boxes, &KdSettings::default(), tree),
        tree: KdTree::default(),
        wrap: Tree::Kd,
    })
}

/// Gives the boxes of a tree that is there new sizes: what is timed is refitting alone.
pub(super) fn refit_worker() -> Box<dyn Worker> {
    Box::new(Refit(Bvh::default()))
}

struct Refit(Bvh);

impl Worker for Refit {
    fn prepare(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        if self.0.nodes.is_empty() {
            HybridBvh::default().build(boxes, &BvhSettings::default(), &mut self.0);
        }
        Ok(())
    }

    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        Ok(refit_parallel(&mut self.0, boxes)?)
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        Ok(Tree::Bvh(std::mem::take(&mut self.0)))
    }
}

struct Own<F, T> {
    build: F,
    tree: T,
    wrap: fn(T) -> Tree,
}

impl<F: FnMut(CheckedBoxes<'_>, &mut T) + Send, T: Default + Send> Worker for Own<F, T> {
    fn build(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        (self.build)(boxes, &mut self.tree);
        Ok(())
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        Ok((self.wrap)(std::mem::take(&mut self.tree)))
    }
}
