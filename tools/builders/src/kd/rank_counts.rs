use super::cell_cost::CellCost;
use super::ranked_fragment::Ranked;

/// Ranks of a box's sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RankBox {
    pub min: [u8; 3],
    pub max: [u8; 3],
}

/// The cheapest plane of a node, as a rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RankCut {
    pub cost: f32,
    pub axis: usize,
    pub rank: u8,
    /// Fragments of the left child.
    pub left: u32,
    /// Fragments of the right child.
    pub right: u32,
}

/// Counters of where the fragments of one node begin and end, by rank, and the positions of the ranks.
///
/// 256 ranks and eight more, so that eight can be read at any.
#[derive(Debug)]
pub(super) struct RankCounts {
    /// Positions of the ranks, from that of rank zero.
    offsets: [[f32; 264]; 3],
    /// Fragments that begin at a rank: what a plane behind it adds to its left side.
    starts: [[u8; 264]; 3],
    /// Fragments that end at a rank: what a plane here takes from its right side.
    ends: [[u8; 264]; 3],
    /// The tests expected of a cut at a rank.
    prices: [[f32; 264]; 3],
}

/// A product with it sums the bytes of a word up to each.
const ONES: u64 = 0x0101_0101_0101_0101;

impl RankCounts {
    pub(super) fn new() -> Self {
        Self {
            offsets: [[0.0; 264]; 3],
            starts: [[0; 264]; 3],
            ends: [[0; 264]; 3],
            prices: [[0.0; 264]; 3],
        }
    }

    /// Sets the positions of the ranks along `axis`: at least one, at most 256.
    pub(super) fn set_positions(&mut self, axis: usize, positions: &[f32]) {
        let first = positions[0];
        let offsets = &mut self.offsets[axis];
        for (offset, position) in offsets.iter_mut().zip(positions) {
            *offset = position - first;
        }
        // A sweep in steps of eight reads beyond the last: planes there cost more than a leaf.
        let last = offsets[positions.len() - 1];
        offsets[positions.len()..positions.len() + 8].fill(last);
    }

    /// Counts where the fragments of a node begin and end; the box around them.
    #[inline(always)]
    pub(super) fn count(&mut self, list: &[Ranked]) -> RankBox {
        let (mut lower, mut upper) = ([255u8; 3], [0u8; 3]);
        for ranked in list {
            for axis in 0..3 {
                let (min, max) = (ranked.min(axis), ranked.max(axis));
                self.starts[axis][usize::from(min)] += 1;
                self.ends[axis][usize::from(max)] += 1;
                lower[axis] = lower[axis].min(min);
                upper[axis] = upper[axis].max(max);
            }
        }
        RankBox { min: lower, max: upper }
    }

    /// Sets all counters back to zero.
    #[inline(always)]
    pub(super) fn uncount(&mut self, list: &[Ranked]) {
        for ranked in list {
            for axis in 0..3 {
                let (min, max) = (ranked.min(axis), ranked.max(axis));
                self.starts[axis][usize::from(min)] = 0;
                self.ends[axis][usize::from(max)] = 0;
            }
        }
    }

    /// The cheapest cut of a cell with `count` fragments, which were counted and have the box `bounds` around them; `None` if
    /// none costs less than a leaf.
    #[inline(always)]
    pub(super) fn cheapest_cut(
        &mut self,
        cell: &RankBox,
        bounds: &RankBox,
        count: usize,
        cost: &CellCost,
    ) -> Option<RankCut> {
        let mut best = self.cheapest_gap(cell, bounds, count, cost);
        let limit = best.map_or(cost.leaf(count), |best| best.cost);
        let (mut cheapest, mut winner) = (f32::INFINITY, 3);
        for axis in 0..3 {
            let least = self.sweep(axis, [cell.min[axis], cell.max[axis]], cost, count);
            if least < cheapest {
                (cheapest, winner) = (least, axis);
            }
        }
        let price = cost.traversal + cost.intersection * cheapest;
        if winner < 3 && price < limit {
            let (min, max) = (usize::from(cell.min[winner]), usize::from(cell.max[winner]));
            let mut rank = self.rank_of(winner, min + 1, cheapest).filter(|&rank| rank < max)?;
            // Of two ranks at one position the second has what is flat there on its left, which is preferred.
            let (prices, offsets) = (&self.prices[winner], &self.offsets[winner]);
            if rank + 1 < max && prices[rank + 1] == cheapest && offsets[rank + 1] == offsets[rank] {
                rank += 1;
            }
            let ended = sum(&self.ends[winner], min, rank);
            best = Some(RankCut {
                cost: price,
                axis: winner,
                rank: rank as u8,
                left: sum(&self.starts[winner], min, rank - 1),
                right: count as u32 - ended,
            });
        }
        best
    }

    /// The cheapest of the cuts that take off empty space.
    #[inline(always)]
    fn cheapest_gap(&self, cell: &RankBox, bounds: &RankBox, total: usize, cost: &CellCost) -> Option<RankCut> {
        let (mut limit, mut best) = (cost.leaf(total), None);
        let total = total as u32;
        let mut offer = |axis: usize, rank: u8, left: u32, t: f32| {
            let right = total - left;
            let price = cost.cut(axis, t, left as f32, right as f32);
            if price < limit {
                limit = price;
                best = Some(RankCut {
                    cost: price,
                    axis,
                    rank,
                    left,
                    right,
                });
            }
        };
        for axis in 0..3 {
            let offset = |rank: u8| self.offsets[axis][usize::from(rank)];
            let (min, max) = (offset(cell.min[axis]), offset(cell.max[axis]));
            let (first, last) = (bounds.min[axis], bounds.max[axis]);
            // Of two ranks at one position, nothing lies between.
            if offset(first) > min {
                offer(axis, first, 0, (offset(first) - min) * cost.inverse[axis]);
            }
            if offset(last) < max {
                offer(axis, last, total, (offset(last) - min) * cost.inverse[axis]);
            }
        }
        best
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

    /// The least price of cuts inside the cell, and all prices: what the children's tests are expected to be, by Eq. 4.3
    /// without the constants.
    #[inline(always)]
    fn sweep(&mut self, axis: usize, [min, max]: [u8; 2], cost: &CellCost, count: usize) -> f32 {
        let (starts, ends, offsets) = (&self.starts[axis], &self.ends[axis], &self.offsets[axis]);
        let flat = cost.flat[axis];
        let per_length = cost.inverse[axis] * (1.0 - flat);
        let base = offsets[usize::from(min)];
        let total = count as f32;
        let mut best = [f32::INFINITY; 8];
        let mut rank = usize::from(min);
        let (mut begun, mut ended) = (0, u64::from(ends[rank]));
        rank += 1;
        while rank < usize::from(max) {
            // No sum exceeds a byte. What begins at a rank lies left of the next one.
            let s = (eight(starts, rank - 1) + begun).wrapping_mul(ONES);
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
            if eight(starts, rank - 1) | eight(starts, rank) | eight(ends, rank) == 0 {
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
