#![expect(unsafe_code, reason = "a C++ object moves between threads")]

use super::{
    super::{list::Threads, tree::Tree, worker::Worker},
    convert::{PeerNode, convert},
    failed,
};
use crate::MeasureError;
use restpose_runtime::{Aabb, build::CheckedBoxes};
use tinybvh_rs::bvh::{BVH, BVHData};

const NAME: &str = "tinybvh";

/// It starts threads of its own, unless it was compiled without.
pub(super) const THREADS: Threads = match option_env!("CXXFLAGS") {
    Some(flags) if has_no_threads(flags) => Threads::One,
    _ => Threads::All,
};

/// Whether `flags` define what compiles its threads out. Constant functions cannot search text.
const fn has_no_threads(flags: &str) -> bool {
    let (flags, word) = (flags.as_bytes(), b"-DNO_THREADED_BUILDS");
    let mut start = 0;
    while start + word.len() <= flags.len() {
        let mut length = 0;
        while length < word.len() && flags[start + length] == word[length] {
            length += 1;
        }
        if length == word.len() {
            return true;
        }
        start += 1;
    }
    false
}

#[derive(Default)]
struct TinyBvh {
    /// A degenerate triangle per box, from corner to corner, whose box it is.
    corners: Vec<[f32; 4]>,
    boxes: Vec<Aabb>,
    built: Built,
}

#[derive(Default)]
struct Built(Option<BVHData>);

// SAFETY: the object owns its arrays and no thread; it refers to the corners only while it is built or traced, and is used
// by one thread at a time.
unsafe impl Send for Built {}

/// Its object keeps its memory from one build to the next.
pub(super) fn worker() -> Box<dyn Worker> {
    Box::new(TinyBvh::default())
}

impl Worker for TinyBvh {
    fn prepare(&mut self, boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        let corner = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let corners = |bounds: &Aabb| [bounds.min, bounds.max, bounds.min].map(corner);
        self.corners = boxes.get().iter().flat_map(corners).collect();
        self.boxes = boxes.get().to_vec();
        Ok(())
    }

    fn build(&mut self, _boxes: CheckedBoxes<'_>) -> Result<(), MeasureError> {
        let corners = || self.corners.as_slice().into();
        let refused = |error| failed(NAME, format!("{error}"));
        let built = match self.built.0.take() {
            Some(data) => data.bvh(corners()).and_then(|bvh| bvh.build(corners())),
            None => BVH::new(corners()),
        };
        self.built.0 = Some(built.map_err(refused)?.data());
        Ok(())
    }

    fn take_tree(&mut self) -> Result<Tree, MeasureError> {
        let built = self.built.0.as_ref().ok_or_else(|| failed(NAME, "nothing was built"))?;
        let (nodes, ids) = (built.nodes(), built.indices());
        let node = |place: usize| {
            let node = nodes.get(place)?;
            let first = node.left_first as usize;
            Some(match node.tri_count as usize {
                0 => PeerNode::Inner([first, first + 1]),
                count => PeerNode::Leaf(ids.get(first..first + count)?),
            })
        };
        Ok(Tree::Bvh(convert(NAME, &self.boxes, 0, node)?))
    }
}
