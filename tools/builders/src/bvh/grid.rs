use super::BvhBuilder;
use super::blocks::{BLOCK, distribute, list_boxes_in_blocks};
use super::lane_box::LaneBox;
use super::primitive::{Extent, Primitive, set_len};
use super::subtree::{DEFAULT_LEAF_SIZE, Span};
use super::top::{TopNode, join_subtrees};
use super::vertical::build_subtrees;
use rayon::prelude::*;
use restpose_runtime::build::{Bvh, BvhNode, BvhSettings, CheckedBoxes};

/// How often space is halved before sub-trees begin.
const SPLITS: usize = 7;

/// Sub-trees at most. Wald has about ten per thread, which would make the tree depend on the threads; this many are enough
/// for a dozen.
const CELLS: usize = 1 << SPLITS;

/// Builds by a regular grid and binning in its cells, on all threads of the current pool.
///
/// The box around everything is halved 7 times across its longest side, which gives a grid of 128 cells. The cell of each
/// primitive's centroid is found in one pass. Cells become sub-trees by binning, as [`BinnedBvh`](super::BinnedBvh)
/// builds them; the upper levels are the halvings, their boxes made from those below, and a half without primitives
/// makes no node.
///
/// Guarantee: the tree does not depend on the number of threads. No guarantee about cost: the upper levels are not chosen
/// by it.
///
/// Complexity: as that of `BinnedBvh`. Memory beside the tree: 64 bytes per box, and once more the nodes.
///
/// Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §4.2.
#[derive(Debug)]
pub struct GridBvh {
    /// Nodes with so many primitives or fewer become leaves, 0 counting as 1. Default [`DEFAULT_LEAF_SIZE`].
    pub leaf_size: usize,
    lists: [Vec<Primitive>; 2],
    subtrees: Vec<Vec<BvhNode>>,
}

impl Default for GridBvh {
    fn default() -> Self {
        Self {
            leaf_size: DEFAULT_LEAF_SIZE,
            lists: Default::default(),
            subtrees: Vec::new(),
        }
    }
}

impl BvhBuilder for GridBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        for list in &mut self.lists {
            set_len(list, boxes.len(), Primitive::default());
        }
        set_len(&mut tree.references, boxes.len(), 0);
        let [list, cells] = &mut self.lists;
        let extent = list_boxes_in_blocks(boxes, list);
        let grid = Grid::new(&extent.bounds);
        let counts: Vec<_> = list.par_chunks(BLOCK).map(|block| grid.count(block)).collect();
        distribute(list, cells, &counts, |_: &mut (), primitive| grid.cell(primitive));

        let mut per_cell = [0; CELLS];
        for counts in &counts {
            for (all, count) in per_cell.iter_mut().zip(counts) {
                *all += count;
            }
        }
        let (mut top, mut spans) = (Vec::new(), Vec::new());
        add_cells(Span::root(cells, &mut tree.references), &per_cell, &mut top, &mut spans);
        let spans: Vec<_> = spans
            .into_par_iter()
            .map(|span| {
                let extent = Extent::of(span.primitives);
                (span, extent)
            })
            .collect();
        let count = spans.len();
        build_subtrees(spans, settings, self.leaf_size, &mut self.subtrees);
        join_subtrees(&top, &self.subtrees[..count], &mut tree.nodes);
    }
}

/// Adds the node over the cells with the given counts, at least one of which is occupied, and those below.
fn add_cells<'a>(span: Span<'a>, mut counts: &[usize], top: &mut Vec<TopNode>, spans: &mut Vec<Span<'a>>) {
    while counts.len() > 1 {
        let (lower, upper) = counts.split_at(counts.len() / 2);
        let left = lower.iter().sum();
        if left != 0 && left != span.primitives.len() {
            let index = top.len();
            top.push(TopNode::Inner([0; 2]));
            let children = span.split_at(left);
            let mut places = [0; 2];
            for ((place, child), counts) in places.iter_mut().zip(children).zip([lower, upper]) {
                *place = top.len();
                add_cells(child, counts, top, spans);
            }
            top[index] = TopNode::Inner(places);
            return;
        }
        counts = if left == 0 { upper } else { lower };
    }
    top.push(TopNode::Subtree(spans.len()));
    spans.push(span);
}

/// Cells of equal size, numbered as the halvings order them: the first halving gives the highest bit.
#[derive(Debug)]
struct Grid {
    axes: [GridAxis; 3],
}

/// Cells along one axis.
#[derive(Clone, Copy, Debug)]
struct GridAxis {
    least: f64,
    factor: f64,
    /// The bits of a cell's number, by its place along the axis.
    bits: [u8; CELLS],
    /// Places there are.
    places: usize,
}

impl Grid {
    fn new(bounds: &LaneBox) -> Self {
        let sides: [[f64; 2]; 3] = std::array::from_fn(|k| bounds.sides(k).map(f64::from));
        let mut lengths = sides.map(|[lower, upper]| upper - lower);
        let whole = lengths;
        let mut axes = sides.map(|[least, _]| GridAxis {
            least,
            factor: 0.0,
            bits: [0; CELLS],
            places: 1,
        });
        for split in (0..SPLITS).rev() {
            let longest = (0..3).fold(0, |a, b| if lengths[b] > lengths[a] { b } else { a });
            lengths[longest] *= 0.5;
            axes[longest].halve(1 << split);
        }
        for (axis, whole) in axes.iter_mut().zip(whole) {
            if whole > 0.0 {
                axis.factor = axis.places as f64 / whole;
            }
        }
        Self { axes }
    }

    #[inline]
    fn cell(&self, primitive: &Primitive) -> usize {
        let center = primitive.bounds().center().to_array();
        let bits = |k: usize| self.axes[k].bits_at(center[k]);
        usize::from(bits(0) | bits(1) | bits(2))
    }

    /// Primitives per cell.
    fn count(&self, primitives: &[Primitive]) -> Vec<usize> {
        let mut counts = vec![0; CELLS];
        for primitive in primitives {
            counts[self.cell(primitive)] += 1;
        }
        counts
    }
}

impl GridAxis {
    /// Halves each place; `bit` tells upper halves.
    fn halve(&mut self, bit: u8) {
        for place in (0..self.places).rev() {
            let bits = self.bits[place];
            self.bits[2 * place] = bits;
            self.bits[2 * place + 1] = bits | bit;
        }
        self.places *= 2;
    }

    #[inline]
    fn bits_at(&self, centroid: f32) -> u8 {
        let place = (f64::from(centroid) - self.least) * self.factor;
        // The greatest centroid may be on the upper border.
        self.bits[(place as u8 as usize).min(self.places - 1)]
    }
}
