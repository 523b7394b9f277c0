//! The exact sweep for small nodes: positions become ranks, and sorted lists become counters.
//!
//! A node of at most [`RankedCells::MAX_COUNT`] fragments has at most 256 different positions along an axis, the sides of
//! its cell included. They are sorted once; from there on a fragment is six bytes, the ranks of its sides. Below, a node
//! counts how many fragments begin and end at each rank, which takes no sorting, and eight ranks are swept at a time.
//!
//! Source of the cost and its candidates: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.1.2.

use super::cell_cost::CellCost;
use super::fragment::Fragment;
use super::growth::{OpenNode, Stop};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, KdNodeRow};
use restpose_runtime::build::{KdSettings, KdTree};
use std::ops::Range;

/// A fragment as ranks, in one word.
///
/// ```text
/// [23..0]  ranks where it begins, eight bits per axis      [31..24] its place among the fragments that were ranked
/// [55..32] ranks where it ends                             [63..56] zero
/// ```
#[derive(Clone, Copy, Debug, Default)]
struct Ranked(u64);

impl Ranked {
    #[inline(always)]
    fn min(self, axis: usize) -> u8 {
        (self.0 >> (8 * axis)) as u8
    }

    #[inline(always)]
    fn max(self, axis: usize) -> u8 {
        (self.0 >> (8 * axis + 32)) as u8
    }

    fn place(self) -> usize {
        (self.0 >> 24) as usize & 0xff
    }
}

/// A product with it sums the bytes of a word up to each.
const ONES: u64 = 0x0101_0101_0101_0101;

/// Builds sub-trees of few fragments; owns all scratch memory.
#[derive(Debug)]
pub(super) struct RankedCells {
    /// Positions by rank, per axis, from the lower side of the cell that was ranked.
    offsets: [[f32; 264]; 3],
    positions: [[f32; 256]; 3],
    /// Fragments that begin before a rank but not before the one below it; those that lie in it count as such.
    starts: [[u8; 264]; 3],
    /// Fragments that end at a rank.
    ends: [[u8; 264]; 3],
    keys: Vec<u64>,
    list: Vec<Ranked>,
    spare: Vec<Ranked>,
    /// What the tests of a cut at a rank cost, per axis.
    prices: [[f32; 264]; 3],
    open: Vec<(OpenNode, RankCell, Range<usize>)>,
}

/// Ranks of a cell's sides.
#[derive(Clone, Copy, Debug, Default)]
struct RankCell {
    min: [u8; 3],
    max: [u8; 3],
}

/// The cheapest plane of a node, as a rank.
#[derive(Clone, Copy, Debug)]
struct RankCut {
    cost: f32,
    axis: usize,
    rank: u8,
    planar_left: bool,
    left: u32,
    right: u32,
}

impl Default for RankedCells {
    fn default() -> Self {
        Self {
            offsets: [[0.0; 264]; 3],
            positions: [[0.0; 256]; 3],
            starts: [[0; 264]; 3],
            ends: [[0; 264]; 3],
            keys: Vec::new(),
            list: Vec::new(),
            spare: Vec::new(),
            prices: [[0.0; 264]; 3],
            open: Vec::new(),
        }
    }
}

impl RankedCells {
    /// Two sides each and two of the cell make 256 ranks.
    pub(super) const MAX_COUNT: usize = 127;

    /// Grows the sub-tree of `node` over `fragments`.
    pub(super) fn grow(
        &mut self,
        node: OpenNode,
        fragments: &[Fragment],
        settings: &KdSettings,
        stop: Stop,
        tree: &mut KdTree,
    ) {
        let count = fragments.len();
        self.list.clear();
        self.list.extend((0..count).map(|place| Ranked((place as u64) << 24)));
        let mut cell = RankCell::default();
        for axis in 0..3 {
            (cell.min[axis], cell.max[axis]) = self.rank(axis, fragments, &node.cell);
        }
        self.open.push((node, cell, 0..count));
        while let Some((mut node, mut cell, range)) = self.open.pop() {
            let count = range.len();
            if stop.here(count, &node.cell) {
                self.close(&node, range, fragments, tree);
                continue;
            }
            let bounds = self.count(range.clone());
            loop {
                let cut = self.cheapest_cut(&node, &cell, &bounds, count, settings);
                let room = tree.nodes.len() + 2 <= KdNodeRow::MAX_INDEX as usize;
                let Some(cut) = cut.filter(|cut| room && node.allows((cut.left + cut.right) as usize)) else {
                    self.uncount(range.clone());
                    self.close(&node, range, fragments, tree);
                    break;
                };
                let position = self.positions[cut.axis][usize::from(cut.rank)];
                if cut.left == 0 {
                    node.shrink(cut.axis, position, true, count, tree);
                    cell.min[cut.axis] = cut.rank;
                } else if cut.right == 0 {
                    node.shrink(cut.axis, position, false, count, tree);
                    cell.max[cut.axis] = cut.rank;
                } else {
                    self.uncount(range.clone());
                    let [left, right] = self.part(range, &cut);
                    let [lower, upper] = node.cut(cut.axis, position, left.len(), right.len(), tree);
                    let (mut below, mut above) = (cell, cell);
                    below.max[cut.axis] = cut.rank;
                    above.min[cut.axis] = cut.rank;
                    self.open.push((lower, below, left));
                    self.open.push((upper, above, right));
                    break;
                }
            }
        }
    }

    fn close(&self, node: &OpenNode, range: Range<usize>, fragments: &[Fragment], tree: &mut KdTree) {
        tree.nodes[node.index] = KdNodeRow::pack(KdNode::Leaf {
            first: tree.references.len() as u32,
            count: range.len() as u32,
        });
        let ids = self.list[range].iter().map(|ranked| fragments[ranked.place()].id());
        tree.references.extend(ids);
    }

    /// Ranks the sides of all fragments and of the cell along `axis`; the ranks of the cell's sides.
    fn rank(&mut self, axis: usize, fragments: &[Fragment], cell: &Aabb) -> (u8, u8) {
        let count = fragments.len();
        self.keys.clear();
        for (place, fragment) in fragments.iter().enumerate() {
            self.keys.push(key(fragment.min[axis], place));
            self.keys.push(key(fragment.max[axis], place + 128));
        }
        self.keys.sort_unstable();
        let (min, max) = (cell.min[axis], cell.max[axis]);
        let mut rank = 0;
        let mut last = min;
        self.set(axis, rank, min, min);
        for next in 0..self.keys.len() {
            let key = self.keys[next];
            let position = number((key >> 32) as u32);
            if position != last {
                rank += 1;
                last = position;
                self.set(axis, rank, position, min);
            }
            let place = (key & 0x7f) as usize;
            let ranked = &mut self.list[place];
            let shift = 8 * axis + if key & 0x80 == 0 { 0 } else { 32 };
            ranked.0 |= (rank as u64) << shift;
        }
        if max != last {
            rank += 1;
            self.set(axis, rank, max, min);
        }
        debug_assert!(rank < 256 && count <= Self::MAX_COUNT);
        let last = self.offsets[axis][rank];
        self.offsets[axis][rank + 1..rank + 8].fill(last);
        (0, rank as u8)
    }

    fn set(&mut self, axis: usize, rank: usize, position: f32, base: f32) {
        self.positions[axis][rank] = position;
        self.offsets[axis][rank] = position - base;
    }

    /// Counts where the fragments of a node begin and end; the box around them.
    #[inline(always)]
    fn count(&mut self, range: Range<usize>) -> RankCell {
        let (mut lower, mut upper) = ([255u8; 3], [0u8; 3]);
        for ranked in &self.list[range] {
            for axis in 0..3 {
                let (min, max) = (ranked.min(axis), ranked.max(axis));
                self.starts[axis][usize::from(min) + usize::from(min != max)] += 1;
                self.ends[axis][usize::from(max)] += 1;
                lower[axis] = lower[axis].min(min);
                upper[axis] = upper[axis].max(max);
            }
        }
        RankCell { min: lower, max: upper }
    }

    /// Sets all counters back to zero.
    #[inline(always)]
    fn uncount(&mut self, range: Range<usize>) {
        for ranked in &self.list[range] {
            for axis in 0..3 {
                let (min, max) = (ranked.min(axis), ranked.max(axis));
                self.starts[axis][usize::from(min) + usize::from(min != max)] = 0;
                self.ends[axis][usize::from(max)] = 0;
            }
        }
    }

    /// The cheapest cut, if one costs less than a leaf.
    #[inline(always)]
    fn cheapest_cut(
        &mut self,
        node: &OpenNode,
        cell: &RankCell,
        bounds: &RankCell,
        count: usize,
        settings: &KdSettings,
    ) -> Option<RankCut> {
        let cost = CellCost::new(&node.cell, settings);
        let mut best = RankCut {
            cost: cost.leaf(count),
            axis: 3,
            rank: 0,
            planar_left: true,
            left: 0,
            right: 0,
        };
        let total = count as u32;
        let mut offer = |axis: usize, rank: u8, planar_left: bool, left: u32, right: u32, t: f32| {
            let price = cost.cut(axis, t, left as f32, right as f32);
            if price < best.cost {
                best = RankCut {
                    cost: price,
                    axis,
                    rank,
                    planar_left,
                    left,
                    right,
                };
            }
        };
        for axis in 0..3 {
            let offsets = &self.offsets[axis];
            let (min, max) = (cell.min[axis], cell.max[axis]);
            if min == max {
                continue;
            }
            let (first, last) = (bounds.min[axis], bounds.max[axis]);
            let share = |rank: u8| (offsets[usize::from(rank)] - offsets[usize::from(min)]) * cost.inverse[axis];
            if first > min {
                offer(axis, first, true, 0, total, share(first));
            } else {
                let flat = u32::from(self.starts[axis][usize::from(min)]);
                if flat > 0 {
                    offer(axis, min, true, flat, total - flat, 0.0);
                }
            }
            if last < max {
                offer(axis, last, false, total, 0, share(last));
            }
        }
        let mut cheapest = f32::INFINITY;
        let mut winner = 3;
        for axis in 0..3 {
            let least = self.sweep(axis, [cell.min[axis], cell.max[axis]], &cost, count);
            if least < cheapest {
                cheapest = least;
                winner = axis;
            }
        }
        let price = cost.traversal + cost.intersection * cheapest;
        if winner < 3 && price < best.cost {
            let (min, max) = (usize::from(cell.min[winner]), usize::from(cell.max[winner]));
            let rank = self.rank_of(winner, min + 1, cheapest)?;
            if rank >= max {
                return None;
            }
            let (left, ended) = (sum(&self.starts[winner], min, rank), sum(&self.ends[winner], min, rank));
            best = RankCut {
                cost: price,
                axis: winner,
                rank: rank as u8,
                planar_left: true,
                left,
                right: total - ended,
            };
        }
        (best.axis < 3).then_some(best)
    }

    /// The first rank from `begin` on whose price is `price`, in steps of eight.
    #[inline(always)]
    fn rank_of(&self, axis: usize, begin: usize, price: f32) -> Option<usize> {
        let mut rank = begin;
        while let Some(prices) = self.prices[axis][rank..].first_chunk::<8>() {
            if prices.iter().fold(false, |found, &p| found | (p == price)) {
                return prices.iter().position(|&p| p == price).map(|k| rank + k);
            }
            rank += 8;
        }
        None
    }

    /// The least price of the tests for cuts inside the cell.
    #[inline(always)]
    fn sweep(&mut self, axis: usize, [min, max]: [u8; 2], cost: &CellCost, count: usize) -> f32 {
        let (starts, ends, offsets) = (&self.starts[axis], &self.ends[axis], &self.offsets[axis]);
        let flat = cost.flat[axis];
        let per_length = cost.inverse[axis] * (1.0 - flat);
        let base = offsets[usize::from(min)];
        let total = count as f32;
        let mut best = [f32::INFINITY; 8];
        let mut rank = usize::from(min);
        let (mut begun, mut ended) = (u64::from(starts[rank]), u64::from(ends[rank]));
        rank += 1;
        while rank < usize::from(max) {
            // No sum exceeds a byte.
            let s = (eight(starts, rank) + begun).wrapping_mul(ONES);
            let e = (eight(ends, rank) + ended).wrapping_mul(ONES);
            begun = s >> 56;
            ended = e >> 56;
            let (s, e) = (s.to_le_bytes(), e.to_le_bytes());
            let (Some(offset), Some(prices)) = (
                offsets[rank..].first_chunk::<8>(),
                self.prices[axis][rank..].first_chunk_mut::<8>(),
            ) else {
                break;
            };
            if eight(starts, rank) | eight(ends, rank) == 0 {
                // Between sides of fragments no cut is cheapest.
                prices.fill(f32::INFINITY);
                rank += 8;
                continue;
            }
            for k in 0..8 {
                let (left, gone) = (f32::from(s[k]), f32::from(e[k]));
                let rim = (offset[k] - base) * per_length;
                let price = (total - gone) + flat * left + rim * (left + gone - total);
                prices[k] = price;
                best[k] = if price < best[k] { price } else { best[k] };
            }
            rank += 8;
        }
        let mut least = f32::INFINITY;
        for k in 0..8 {
            least = if best[k] < least { best[k] } else { least };
        }
        least
    }

    #[inline(always)]
    fn part(&mut self, range: Range<usize>, cut: &RankCut) -> [Range<usize>; 2] {
        let begin = range.start;
        self.spare.resize(self.spare.len().max(range.len()), Ranked::default());
        let list = &mut self.list[range];
        let spare = &mut self.spare[..list.len()];
        let (rank, planar_left) = (cut.rank, cut.planar_left);
        let (low, high) = (8 * cut.axis as u32, 8 * cut.axis as u32 + 32);
        let at = u64::from(rank);
        let (mut left, mut right) = (0, 0);
        for next in 0..list.len() {
            let Ranked(word) = list[next];
            let (min, max) = ((word >> low) as u8, (word >> high) as u8);
            let (below, above) = (min < rank, max > rank);
            let cut = if above {
                word & !(0xff << high) | at << high
            } else {
                word
            };
            list[left] = Ranked(cut);
            left += usize::from(below | (planar_left & !above));
            let cut = if below { word & !(0xff << low) | at << low } else { word };
            spare[right] = Ranked(cut);
            right += usize::from(above | (!planar_left & !below));
        }
        let (middle, end) = (begin + left, begin + left + right);
        if self.list.len() < end {
            self.list.resize(end, Ranked::default());
        }
        self.list[middle..end].copy_from_slice(&self.spare[..right]);
        [begin..middle, middle..end]
    }
}

/// The sum of the counters of the ranks `first` to `last`.
#[inline(always)]
fn sum(counts: &[u8; 264], first: usize, last: usize) -> u32 {
    let mut total = 0;
    let mut rank = first;
    while rank + 8 <= last {
        total += eight(counts, rank).wrapping_mul(ONES) >> 56;
        rank += 8;
    }
    // Of the last eight only those up to `last`.
    let rest = eight(counts, rank) << (8 * (7 - (last - rank)));
    (total + (rest.wrapping_mul(ONES) >> 56)) as u32
}

#[inline]
fn eight(counts: &[u8; 264], rank: usize) -> u64 {
    counts[rank..rank + 8].try_into().map_or(0, u64::from_le_bytes)
}

fn key(position: f32, place: usize) -> u64 {
    let bits = position.to_bits();
    let order = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(order) << 32 | place as u64
}

fn number(order: u32) -> f32 {
    f32::from_bits(if order >> 31 == 1 { order & !(1 << 31) } else { !order })
}
