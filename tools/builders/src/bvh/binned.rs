use super::BvhBuilder;
use super::primitive::{Primitive, list_boxes, set_len};
use super::subtree::{DEFAULT_LEAF_SIZE, Span, SubtreeBuilder};
use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes};

/// Builds by binning, on one thread: 16 bins over the centroids' widest axis.
///
/// A node becomes a leaf at [`leaf_size`](Self::leaf_size) primitives, where all centroids coincide, or where no split
/// between bins is cheaper by Eq. 4.3 (Günther 2014).
///
/// Complexity: O(n log n) for boxes whose bins fill evenly, at most O(n) per level of the tree. Memory beside the tree:
/// 32 bytes per box.
///
/// Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §3.
#[derive(Debug)]
pub struct BinnedBvh {
    /// Nodes with so many primitives or fewer become leaves, 0 counting as 1. Default [`DEFAULT_LEAF_SIZE`].
    pub leaf_size: usize,
    primitives: Vec<Primitive>,
}

impl Default for BinnedBvh {
    fn default() -> Self {
        Self {
            leaf_size: DEFAULT_LEAF_SIZE,
            primitives: Vec::new(),
        }
    }
}

impl BvhBuilder for BinnedBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        set_len(&mut self.primitives, boxes.len(), Primitive::default());
        set_len(&mut tree.references, boxes.len(), 0);
        let extent = list_boxes(boxes, 0, &mut self.primitives);
        let span = Span::root(&mut self.primitives, &mut tree.references);
        SubtreeBuilder::new(settings, self.leaf_size).build(span, &extent, &mut tree.nodes);
    }
}
