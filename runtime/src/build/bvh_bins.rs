use super::bvh_eight::{EightBoxes, cheapest};
use super::bvh_primitive::{BoxLanes, around};
use crate::simd::Lanes;

/// How many bins a node has along each axis: its primitives over `ratio`, kept from `min` to `max`.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BinCount {
    /// Primitives per bin, 1 or more.
    pub ratio: u32,
    /// 2 to [`BinCount::LIMIT`].
    pub min: u32,
    /// `min` to [`BinCount::LIMIT`].
    pub max: u32,
}

impl BinCount {
    /// Most bins along an axis: those of a node fit a first-level cache.
    pub const LIMIT: u32 = MOST_BINS as u32;

    /// The dissertation's default.
    pub const ACCURATE: Self = Self {
        ratio: 6,
        min: 8,
        max: 128,
    };

    /// The dissertation's fast settings.
    pub const FAST: Self = Self {
        ratio: 16,
        min: 4,
        max: 32,
    };

    /// Bins for so many primitives, 2 to [`BinCount::LIMIT`]: settings outside their ranges count as the nearest inside.
    #[must_use]
    #[inline(always)]
    pub fn of(self, primitives: usize) -> usize {
        let max = self.max.clamp(2, Self::LIMIT) as usize;
        let min = (self.min as usize).clamp(2, max);
        (primitives / self.ratio.max(1) as usize).clamp(min, max)
    }
}

const MOST_BINS: usize = 128;

/// Parts of the list that are binned side by side: neighbours in the list are most often neighbours in space, and a
/// primitive would wait until the one before is in the box of their bin.
const STREAMS: usize = 4;

/// Boxes of the primitives in each bin, per axis, and how many they are.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    boxes: [[BoxLanes; MOST_BINS]; 3],
    /// Of each border.
    costs: [[f32; MOST_BINS + 8]; 3],
    /// Room for primitives that stand for all of a node's.
    pub sample: Vec<BoxLanes>,
}

/// A border between two bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    pub axis: usize,
    /// The first bin above.
    pub bin: usize,
}

impl Bins {
    pub(super) const EMPTY: Self = Self {
        boxes: [[BoxLanes::EMPTY; MOST_BINS]; 3],
        costs: [[0.0; MOST_BINS + 8]; 3],
        sample: Vec::new(),
    };

    /// Bins all primitives along all axes in one pass.
    #[inline(always)]
    pub(super) fn fill<S: Lanes>(&mut self, simd: S, primitives: &[BoxLanes], map: &BinMap<S>) {
        for axis in 0..3 {
            self.boxes[axis][..map.count.next_multiple_of(8)].fill(BoxLanes::EMPTY);
        }
        let quarter = primitives.len() / STREAMS;
        let (quarters, rest) = primitives.split_at(STREAMS * quarter);
        let [(a, b), (c, d)] = {
            let (low, high) = quarters.split_at(2 * quarter);
            [low.split_at(quarter), high.split_at(quarter)]
        };
        for (((a, b), c), d) in a.iter().zip(b).zip(c).zip(d) {
            self.add(simd, a, map);
            self.add(simd, b, map);
            self.add(simd, c, map);
            self.add(simd, d, map);
        }
        for primitive in rest {
            self.add(simd, primitive, map);
        }
    }

    #[inline(always)]
    fn add<S: Lanes>(&mut self, simd: S, primitive: &BoxLanes, map: &BinMap<S>) {
        let bins = map.bins(simd, primitive);
        let bounds = simd.load8(&primitive.0);
        for axis in 0..3 {
            let bin = bins[axis] as usize % MOST_BINS;
            let own = &mut self.boxes[axis][bin].0;
            simd.store8(simd.max8_counting(bounds, simd.load8(own)), own);
        }
    }

    /// The border at which the sum of both sides' half areas times their numbers is least, if it is below `limit`; of
    /// equal ones the lowest axis, then the highest bin. Numbers above 2²⁴ are rounded; none becomes zero.
    #[inline(always)]
    pub(super) fn best_border<S: Lanes>(&mut self, simd: S, count: usize, scale: S::F4, limit: f32) -> Option<Border> {
        if count <= 8 {
            return self.best_of_eight(simd, scale, limit);
        }
        let scale = simd.join(scale, scale);
        let infinity = simd.splat8(f32::INFINITY);
        let blocks = count.div_ceil(8);
        let mut least = [infinity; 3];
        for axis in 0..3 {
            // Primitives in the bins below each border, and in all.
            let mut below = [0.0; MOST_BINS + 8];
            let bins = self.boxes[axis].as_chunks::<8>().0;
            let costs = &mut self.costs[axis];
            costs[0] = f32::INFINITY;
            let (mut union, mut number) = (EightBoxes::empty(simd), 0);
            for block in 0..blocks {
                for lane in 0..8 {
                    number += bins[block][lane].count();
                    below[8 * block + lane + 1] = number as f32;
                }
                let counted = simd.load8(below[8 * block + 1..].first_chunk().unwrap());
                let boxes = EightBoxes::load(simd, &bins[block]);
                let joined = boxes.joined_below(simd).joined(simd, union);
                let cost = simd.mul8(counted, joined.half_areas(simd, scale));
                simd.store8(cost, costs[8 * block + 1..].first_chunk_mut().unwrap());
                union = joined.only_lane(simd, 7);
            }
            let all = simd.splat8(number as f32);
            let mut union = EightBoxes::empty(simd);
            for block in (0..blocks).rev() {
                let boxes = EightBoxes::load(simd, &bins[block]);
                let joined = boxes.joined_above(simd).joined(simd, union);
                let above = simd.sub8(all, simd.load8(below[8 * block..].first_chunk().unwrap()));
                let costs = costs[8 * block..].first_chunk_mut().unwrap();
                let cost = simd.add8(simd.load8(costs), simd.mul8(above, joined.half_areas(simd, scale)));
                // Where a side is empty this is no number, or infinite.
                let cost = simd.min8(cost, infinity);
                simd.store8(cost, costs);
                least[axis] = simd.min8(least[axis], cost);
                union = joined.only_lane(simd, 0);
            }
        }
        let (best, axis, _) = cheapest(simd, &least, limit)?;
        let best = simd.splat8(best);
        for block in (0..blocks).rev() {
            let costs = simd.load8(self.costs[axis][8 * block..].first_chunk().unwrap());
            let found = simd.le8(costs, best);
            if found != 0 {
                return Some(Border {
                    axis,
                    bin: 8 * block + found.ilog2() as usize,
                });
            }
        }
        None
    }

    /// [`Self::best_border`] where no two blocks have to be joined: without it, builds take 2.5 to 4 % longer.
    #[inline(always)]
    fn best_of_eight<S: Lanes>(&self, simd: S, scale: S::F4, limit: f32) -> Option<Border> {
        let scale = simd.join(scale, scale);
        let mut costs = [scale; 3];
        for axis in 0..3 {
            let bins = self.boxes[axis].first_chunk().unwrap();
            let boxes = EightBoxes::load(simd, bins);
            let (mut below, mut number) = ([0.0; 8], 0);
            for bin in 0..8 {
                below[bin] = number as f32;
                number += bins[bin].count();
            }
            let below = simd.load8(&below);
            let above = simd.sub8(simd.splat8(number as f32), below);
            costs[axis] = boxes.border_costs(simd, below, above, scale);
        }
        let (_, axis, bin) = cheapest(simd, &costs, limit)?;
        Some(Border { axis, bin })
    }

    /// The boxes around what lies below and above a border.
    #[inline(always)]
    pub(super) fn sides<S: Lanes>(&self, simd: S, count: usize, border: Border) -> [BoxLanes; 2] {
        let (below, above) = self.boxes[border.axis][..count].split_at(border.bin);
        [around(simd, below), around(simd, above)]
    }
}

/// Maps half centers to bins that are uniform over their interval, per axis.
///
/// The map never descends, whatever it rounds; so what it sends below a border has smaller centers than what it sends
/// above. Parting by this map therefore parts by the smallest center above the border, which the dissertation stores in
/// each bin for that purpose, and agrees with the counts in the bins bit for bit, where these are of the same primitives.
#[derive(Clone, Copy)]
pub(super) struct BinMap<S: Lanes> {
    low: S::F4,
    factor: S::F4,
    last: S::F4,
    count: usize,
}

impl<S: Lanes> BinMap<S> {
    /// The map for these primitives with `count` bins.
    #[inline(always)]
    pub(super) fn new(simd: S, primitives: &[BoxLanes], count: usize) -> Self {
        let [mut low, mut high] = [f32::INFINITY, f32::NEG_INFINITY].map(|x| [simd.splat4(x); 2]);
        // Two chains, as each minimum waits for the one before.
        for pair in primitives.chunks(2) {
            for (primitive, chain) in pair.iter().zip([0, 1]) {
                let center = primitive.half_center(simd);
                low[chain] = simd.min4(center, low[chain]);
                high[chain] = simd.max4(center, high[chain]);
            }
        }
        let low = simd.min4(low[0], low[1]);
        let high = simd.max4(high[0], high[1]);
        let length = simd.store4(simd.sub4(high, low));
        // Where the interval is so short that this overflows, few bins are used.
        let factor = length.map(|length| (count as f32 / length).min(f32::MAX));
        Self {
            low,
            factor: simd.load4(&factor),
            last: simd.splat4((count - 1) as f32),
            count,
        }
    }

    #[inline(always)]
    fn place(&self, simd: S, primitive: &BoxLanes) -> S::F4 {
        let place = simd.mul4(simd.sub4(primitive.half_center(simd), self.low), self.factor);
        simd.min4(place, self.last)
    }

    #[inline(always)]
    pub(super) fn bins(&self, simd: S, primitive: &BoxLanes) -> [i32; 4] {
        simd.truncate4(self.place(simd, primitive))
    }

    /// Brings those below the border to the front; how many they are.
    ///
    /// Without branches: which side a primitive goes to cannot be foretold.
    #[inline(always)]
    pub(super) fn part(&self, simd: S, primitives: &mut [BoxLanes], border: Border) -> usize {
        let (low, factor) = (
            simd.store4(self.low)[border.axis],
            simd.store4(self.factor)[border.axis],
        );
        // What is truncated is below just when it is itself, negative places too, which a sample's map may have; and the border
        // is at most the last bin, so there is no need to end at that.
        let bin = border.bin as f32;
        let mut below = 0;
        for next in 0..primitives.len() {
            let goes_below = (primitives[next].half_center_along(border.axis) - low) * factor < bin;
            primitives.swap(next, below);
            below += usize::from(goes_below);
        }
        below
    }
}
