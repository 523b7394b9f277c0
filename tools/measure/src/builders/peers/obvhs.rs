use super::{
    super::{tree::Tree, worker::Worker},
    convert::{PeerNode, convert},
    failed,
};
use crate::MeasureError;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
};
use restpose_runtime::build::CheckedBoxes;
use std::time::Duration;

const NAME: &str = "obvhs";

struct Obvhs {
    params: BvhBuildParams,
    own: Vec<Aabb>,
    /// In the runtime's form, for conversion.
    boxes: Vec<restpose_runtime::Aabb>,
    built: Option<Bvh2>,
}

/// Its builders keep no memory from one build to the next. Threads are those of the pool.
pub(super) fn worker(params: BvhBuildParams) -> Box<dyn Worker> {
    Box::new(Obvhs {
        params,
        own: Vec::new(),
        boxes: Vec::new(),
        built: None,
    })
}

impl Worker for Obvhs {
    fn prepare(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        let own = |bounds: &restpose_runtime::Aabb| Aabb::new(bounds.min.into(), bounds.max.into());
        self.own = boxes.get().iter().map(own).collect();
        self.boxes = boxes.get().to_vec();
        Ok(())
    }

    fn build(&mut self, _boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        self.built = Some(build_bvh2(&self.own, self.params, &mut Duration::default()));
        Ok(())
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        let built = self.built.take().ok_or_else(|| failed(NAME, "nothing was built"))?;
        let node = |place: usize| {
            let node = built.nodes.get(place)?;
            let first = node.first_index as usize;
            Some(match node.prim_count as usize {
                0 => PeerNode::Inner([first, first + 1]),
                count => PeerNode::Leaf(built.primitive_indices.get(first..first + count)?),
            })
        };
        Ok(Tree::Bvh(convert(NAME, &self.boxes, 0, node)?))
    }
}
