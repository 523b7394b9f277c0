use super::BvhBuilder;
use super::bins::{BINS, Bins, Projection};
use super::blocks::{BLOCK, distribute, list_boxes_in_blocks};
use super::depth_limit::must_halve;
use super::measure::Measure;
use super::primitive::{Extent, Primitive, set_len};
use super::subtree::{DEFAULT_LEAF_SIZE, Span};
use super::top::{TopNode, join_subtrees};
use super::vertical::build_subtrees;
use rayon::prelude::*;
use restpose_runtime::build::{Bvh, BvhNode, BvhSettings, CheckedBoxes};

/// Nodes with more primitives are parted by all threads together: enough blocks for some threads, and so few nodes that
/// waiting for each other costs little.
const HORIZONTAL_MIN: usize = 4 * BLOCK;

/// Builds by binning on all threads of the current pool: nodes with many primitives horizontally, each by all threads,
/// then sub-trees vertically, each by one.
///
/// Guarantee: the tree is that of [`BinnedBvh`](super::BinnedBvh).
///
/// Complexity: as that of `BinnedBvh`. Memory beside the tree: 64 bytes per box, and once more the nodes.
///
/// Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §4.1. Differs: blocks have a fixed
/// length instead of one per thread; primitives move to a second list and back with the next level.
#[derive(Debug)]
pub struct HybridBvh {
    /// Nodes with so many primitives or fewer become leaves, 0 counting as 1. Default [`DEFAULT_LEAF_SIZE`].
    pub leaf_size: usize,
    lists: [Vec<Primitive>; 2],
    subtrees: Vec<Vec<BvhNode>>,
}

impl Default for HybridBvh {
    fn default() -> Self {
        Self {
            leaf_size: DEFAULT_LEAF_SIZE,
            lists: Default::default(),
            subtrees: Vec::new(),
        }
    }
}

impl BvhBuilder for HybridBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        for list in &mut self.lists {
            set_len(list, boxes.len(), Primitive::default());
        }
        set_len(&mut tree.references, boxes.len(), 0);
        let [list, spare] = &mut self.lists;
        let extent = list_boxes_in_blocks(boxes, list);
        let mut upper = Upper {
            settings,
            leaf_size: self.leaf_size,
            top: Vec::new(),
            spans: Vec::new(),
        };
        upper.part(Span::root(list, &mut tree.references), spare, &extent);
        let Upper { top, spans, .. } = upper;
        let count = spans.len();
        build_subtrees(spans, settings, self.leaf_size, &mut self.subtrees);
        join_subtrees(&top, &self.subtrees[..count], &mut tree.nodes);
    }
}

/// The levels that are built horizontally.
struct Upper<'a> {
    settings: &'a BvhSettings,
    leaf_size: usize,
    top: Vec<TopNode>,
    /// The sub-trees below, from left to right.
    spans: Vec<(Span<'a>, Extent)>,
}

impl<'a> Upper<'a> {
    /// Adds the node over `span`, and those below; `spare` is as long.
    fn part(&mut self, span: Span<'a>, spare: &'a mut [Primitive], extent: &Extent) {
        let index = self.top.len();
        self.top.push(TopNode::Subtree(self.spans.len()));
        let Some((projection, bin, blocks)) = self.split_of(&span, extent) else {
            self.spans.push((span, *extent));
            return;
        };
        let counts: Vec<_> = blocks
            .iter()
            .map(|bins| {
                let left = bins.count_before(bin) as usize;
                vec![left, bins.count_before(BINS) as usize - left]
            })
            .collect();
        let count = counts.iter().map(|counts| counts[0]).sum();
        let extents = distribute(span.primitives, spare, &counts, |sides: &mut Sides, primitive| {
            let side = usize::from(projection.bin(primitive) >= bin);
            sides.0[side].grow(primitive);
            side
        });
        let extents = extents.iter().fold(Sides::default(), |all, block| all.union(block));
        // What was distributed is in the spare list: the lists change places.
        let (span, primitives) = span.with_primitives(spare);
        let [left, right] = span.split_at(count);
        let (left_spare, right_spare) = primitives.split_at_mut(count);
        let left_index = self.top.len();
        self.part(left, left_spare, &extents.0[0]);
        let right_index = self.top.len();
        self.part(right, right_spare, &extents.0[1]);
        self.top[index] = TopNode::Inner([left_index, right_index]);
    }

    /// How to part the primitives, and the bins of each block; `None` for a sub-tree.
    fn split_of(&self, span: &Span<'_>, extent: &Extent) -> Option<(Projection, usize, Vec<Bins>)> {
        let count = span.primitives.len();
        if count <= HORIZONTAL_MIN.max(self.leaf_size) || must_halve(span.depth, count) {
            return None;
        }
        let projection = Projection::new(extent)?;
        let blocks: Vec<_> = span
            .primitives
            .par_chunks(BLOCK)
            .map(|block| {
                let mut bins = Bins::EMPTY;
                bins.fill(block, &projection);
                bins
            })
            .collect();
        let mut bins = Bins::EMPTY;
        for block in &blocks {
            bins.add(block);
        }
        let measure = Measure::new(&extent.bounds);
        let split = bins.cheapest_split(&measure);
        measure
            .split_pays(split.parts, count, self.settings)
            .then_some((projection, split.bin, blocks))
    }
}

/// The extents of two children.
struct Sides([Extent; 2]);

impl Default for Sides {
    fn default() -> Self {
        Self([Extent::EMPTY; 2])
    }
}

impl Sides {
    fn union(self, other: &Self) -> Self {
        let [left, right] = self.0;
        Self([left.union(&other.0[0]), right.union(&other.0[1])])
    }
}
