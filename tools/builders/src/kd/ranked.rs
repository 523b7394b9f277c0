//! The exact sweep for small nodes: positions become ranks, and sorted lists become counters.
//!
//! A node of at most [`RankedCells::MAX_COUNT`] fragments has at most 256 ranks along an axis, those of its cell's sides included. A
//! position where fragments are flat has two ranks, between which these lie: a plane at the first has them on its right, one
//! at the second on its left, and nothing else need know that some fragments are flat. What a plane cuts ends at the first and
//! begins at the second. Positions are sorted once; from there on a fragment is six bytes, the ranks of its sides. Below, a node
//! counts how many fragments begin and end at each rank, which takes no sorting, and eight ranks are swept at a time.
//!
//! Source of the cost and its candidates: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.1.2.

use super::cell_cost::CellCost;
use super::float_order::{number, order};
use super::fragment::Fragment;
use super::growth::{OpenNode, Stop, weight};
use super::rank_counts::{RankBox, RankCounts};
use super::ranked_fragment::{Ranked, RankedStack};
use restpose_formats::rows::{KdNode, KdNodeRow};
use restpose_runtime::build::{KdSettings, KdTree};
use std::ops::Range;

/// Builds sub-trees of few fragments; owns all scratch memory.
#[derive(Debug)]
pub(super) struct RankedCells {
    /// Positions by rank, per axis.
    positions: [Vec<f32>; 3],
    counts: RankCounts,
    stack: RankedStack,
    keys: Vec<u64>,
    open: Vec<(OpenNode, RankBox, Range<usize>)>,
    /// Of the leaves of the sub-tree in work.
    weight: f64,
}

impl RankedCells {
    /// Two sides each and two of the cell make 256 ranks.
    pub(super) const MAX_COUNT: usize = 127;

    pub(super) fn new() -> Self {
        Self {
            positions: Default::default(),
            counts: RankCounts::new(),
            stack: RankedStack::default(),
            keys: Vec::new(),
            open: Vec::new(),
            weight: 0.0,
        }
    }

    /// Grows the sub-tree of `node` over `fragments`, which are at most [`RankedCells::MAX_COUNT`]; what its leaves weigh.
    pub(super) fn grow(
        &mut self,
        node: OpenNode,
        fragments: &[Fragment],
        settings: &KdSettings,
        stop: Stop,
        tree: &mut KdTree,
    ) -> f64 {
        self.weight = 0.0;
        let list = &mut self.stack.list;
        list.clear();
        list.extend((0..fragments.len() as u64).map(Ranked::at));
        let mut cell = RankBox::default();
        for axis in 0..3 {
            cell.max[axis] = self.rank(axis, fragments, [node.cell.min[axis], node.cell.max[axis]]);
        }
        self.open.push((node, cell, 0..fragments.len()));
        while let Some((node, cell, range)) = self.open.pop() {
            if stop.here(range.len(), &node.cell) {
                self.close(&node, range, fragments, tree);
            } else {
                self.split(node, cell, range, fragments, settings, tree);
            }
        }
        self.weight
    }

    /// Cuts off empty space while that is cheapest, then opens both children of `node`, or makes it a leaf.
    #[inline(always)]
    fn split(
        &mut self,
        mut node: OpenNode,
        mut cell: RankBox,
        range: Range<usize>,
        fragments: &[Fragment],
        settings: &KdSettings,
        tree: &mut KdTree,
    ) {
        let count = range.len();
        let bounds = self.counts.count(&self.stack.list[range.clone()]);
        loop {
            let list = &self.stack.list[range.clone()];
            let cost = CellCost::new(&node.cell, settings);
            let cut = self.counts.cheapest_cut(&cell, &bounds, count, &cost);
            let room = tree.nodes.len() + 2 <= KdNodeRow::MAX_INDEX as usize;
            let Some(cut) = cut.filter(|cut| room && node.allows((cut.left + cut.right) as usize)) else {
                self.counts.uncount(list);
                self.close(&node, range, fragments, tree);
                return;
            };
            let position = self.positions[cut.axis][usize::from(cut.rank)];
            if cut.left == 0 {
                node.shrink(cut.axis, position, true, count, tree);
                cell.min[cut.axis] = cut.rank;
            } else if cut.right == 0 {
                node.shrink(cut.axis, position, false, count, tree);
                cell.max[cut.axis] = cut.rank;
            } else {
                self.counts.uncount(list);
                let ends = self.ranks_at(cut.axis, cut.rank);
                let [left, right] = self.stack.part(range, cut.axis, cut.rank, ends);
                let [lower, upper] = node.cut(cut.axis, position, left.len(), right.len(), tree);
                let (mut below, mut above) = (cell, cell);
                below.max[cut.axis] = cut.rank;
                above.min[cut.axis] = cut.rank;
                self.open.push((lower, below, left));
                self.open.push((upper, above, right));
                return;
            }
        }
    }

    /// The first and the last rank at the position of `rank`.
    fn ranks_at(&self, axis: usize, rank: u8) -> [u8; 2] {
        let positions = &self.positions[axis];
        let is_same = |other: Option<u8>| {
            other.filter(|&other| positions.get(usize::from(other)) == positions.get(usize::from(rank)))
        };
        [rank.checked_sub(1), rank.checked_add(1)].map(|other| is_same(other).unwrap_or(rank))
    }

    fn close(&mut self, node: &OpenNode, range: Range<usize>, fragments: &[Fragment], tree: &mut KdTree) {
        tree.nodes[node.index] = KdNodeRow::pack(KdNode::Leaf {
            first: tree.references.len() as u32,
            count: range.len() as u32,
        });
        self.weight += weight(range.len(), &node.cell);
        let list = &self.stack.list[range];
        let ids = list.iter().map(|ranked| fragments[ranked.place()].id());
        tree.references.extend(ids);
    }

    /// Ranks the sides of all fragments along `axis`, and those of the cell, the lowest and the highest; the highest
    /// rank.
    fn rank(&mut self, axis: usize, fragments: &[Fragment], [min, max]: [f32; 2]) -> u8 {
        // Of a key, the low seven bits are the place, and the two above what it is, in the order of ranks at a position.
        const END: u64 = 0;
        const FLAT: u64 = 1;
        const BEGIN: u64 = 2;
        self.keys.clear();
        for (fragment, place) in fragments.iter().zip(0u64..) {
            let (min, max) = (fragment.min[axis], fragment.max[axis]);
            let key = |side: f32, kind: u64| u64::from(order(side)) << 32 | kind << 7 | place;
            if min == max {
                self.keys.push(key(min, FLAT));
            } else {
                self.keys.push(key(min, BEGIN));
                self.keys.push(key(max, END));
            }
        }
        self.keys.sort_unstable();
        let positions = &mut self.positions[axis];
        positions.clear();
        positions.push(min);
        let mut last = min;
        let mut parted = false;
        for &key in &self.keys {
            let position = number((key >> 32) as u32);
            if position != last {
                positions.push(position);
                last = position;
                parted = false;
            }
            let kind = key >> 7 & 3;
            if kind == FLAT && !parted {
                positions.push(position);
                parted = true;
            }
            let rank = positions.len() as u64 - 1;
            let ranks = match kind {
                BEGIN => rank,
                END => rank << 32,
                _ => (rank - 1) | rank << 32,
            };
            self.stack.list[key as usize & 127].0 |= ranks << (8 * axis);
        }
        if max != last {
            positions.push(max);
        }
        self.counts.set_positions(axis, positions);
        (positions.len() - 1) as u8
    }
}
