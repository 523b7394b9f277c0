use super::{
    super::{tree::Tree, worker::Worker},
    convert::{PeerNode, convert},
    failed,
};
use crate::MeasureError;
use bvh::{
    aabb::{Aabb, Bounded},
    bounding_hierarchy::{BHShape, BoundingHierarchy},
    bvh::{Bvh, BvhNode},
};
use restpose_runtime::build::CheckedBoxes;

const NAME: &str = "bvh";

/// A box as its builder takes it.
#[derive(Clone)]
struct Shape {
    bounds: Aabb<f32, 3>,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

#[derive(Default)]
struct BvhCrate {
    shapes: Vec<Shape>,
    /// In the runtime's form, for conversion.
    boxes: Vec<restpose_runtime::Aabb>,
    built: Option<Bvh<f32, 3>>,
}

/// Its builder keeps no memory from one build to the next. Threads are those of the pool.
pub(super) fn worker() -> Box<dyn Worker> {
    Box::new(BvhCrate::default())
}

impl Worker for BvhCrate {
    fn prepare(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        let shape = |bounds: &restpose_runtime::Aabb| Shape {
            bounds: Aabb::with_bounds(bounds.min.into(), bounds.max.into()),
            node: 0,
        };
        self.shapes = boxes.get().iter().map(shape).collect();
        self.boxes = boxes.get().to_vec();
        Ok(())
    }

    fn build(&mut self, _boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        self.built = Some(if rayon::current_num_threads() == 1 {
            Bvh::build(&mut self.shapes)
        } else {
            Bvh::build_par(&mut self.shapes)
        });
        Ok(())
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        let built = self.built.take().ok_or_else(|| failed(NAME, "nothing was built"))?;
        let ids: Vec<u32> = (0..self.boxes.len() as u32).collect();
        let node = |place: usize| {
            Some(match built.nodes.get(place)? {
                BvhNode::Leaf { shape_index, .. } => PeerNode::Leaf(ids.get(*shape_index..=*shape_index)?),
                BvhNode::Node {
                    child_l_index,
                    child_r_index,
                    ..
                } => PeerNode::Inner([*child_l_index, *child_r_index]),
            })
        };
        Ok(Tree::Bvh(convert(NAME, &self.boxes, 0, node)?))
    }
}
