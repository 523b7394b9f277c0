use super::tree::Tree;
use crate::MeasureError;
use restpose_runtime::build::{Bvh, CheckedBoxes, KdTree};

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
pub(super) fn bvh_worker(build: impl FnMut(CheckedBoxes<'_>, &mut Bvh) + Send + 'static) -> Box<dyn Worker> {
    Box::new(Own {
        build,
        tree: Bvh::default(),
        wrap: Tree::Bvh,
    })
}

/// Builds kd-trees by `build`, which owns its scratch memory.
pub(super) fn kd_worker(build: impl FnMut(CheckedBoxes<'_>, &mut KdTree) + Send + 'static) -> Box<dyn Worker> {
    Box::new(Own {
        build,
        tree: KdTree::default(),
        wrap: Tree::Kd,
    })
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
