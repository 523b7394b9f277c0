#![expect(unsafe_code, reason = "a C library's nodes")]

use super::{
    super::{tree::Tree, worker::Worker},
    convert::{PeerNode, convert},
    failed,
};
use crate::{
    MeasureError,
    embree::{BuildPrimitive, Builder, Device, Node, Quality, primitive},
};
use restpose_runtime::{Aabb, build::CheckedBoxes};

const NAME: &str = "Embree";

struct EmbreeWorker {
    embree: Builder,
    primitives: Vec<BuildPrimitive>,
    boxes: Vec<Aabb>,
}

/// It keeps its memory from one build to the next.
pub(super) fn worker(threads: usize, quality: Quality) -> Result<Box<dyn Worker>, MeasureError> {
    let device = Device::new(threads).ok_or_else(|| failed(NAME, "it gives no device"))?;
    Ok(Box::new(EmbreeWorker {
        embree: Builder::new(device, quality),
        primitives: Vec::new(),
        boxes: Vec::new(),
    }))
}

impl Worker for EmbreeWorker {
    fn prepare(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        self.primitives.clear();
        let own = boxes.get().iter().enumerate();
        self.primitives.extend(own.map(|(id, bounds)| primitive(id, bounds)));
        self.boxes = boxes.get().to_vec();
        Ok(())
    }

    fn build(&mut self, _boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        let built = self.embree.build(&mut self.primitives);
        built.map_err(|code| failed(NAME, format!("its build ends with error {code}")))
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        let root = self.embree.root().ok_or_else(|| failed(NAME, "nothing was built"))?;
        let node = |place: usize| {
            // SAFETY: `convert` asks for the root and for children that it was given, and nothing is built meanwhile.
            Some(match unsafe { self.embree.node(place) }? {
                Node::Inner(children) => PeerNode::Inner(children),
                Node::Leaf(ids) => PeerNode::Leaf(ids),
            })
        };
        Ok(Tree::Bvh(convert(NAME, &self.boxes, root, node)?))
    }
}
