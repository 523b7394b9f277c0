use super::bvh_primitive::{BoxLanes, half_area};
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

/// Nodes with fewer primitives use one set of bins: merging would take longer than waiting.
const PAIRED_MIN: usize = 256;

/// Boxes of the primitives in each bin, per axis, and how many they are.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    /// In large nodes every other primitive goes to a second set, so that neighbours in the list, which are most often
    /// neighbours in space, do not wait for each other's box. The sets are merged into the first.
    boxes: [[[BoxLanes; MOST_BINS]; 3]; 2],
    /// Cost of what lies below each border.
    below: [f32; MOST_BINS],
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
        boxes: [[[BoxLanes::EMPTY; MOST_BINS]; 3]; 2],
        below: [0.0; MOST_BINS],
    };

    /// Bins all primitives along all axes in one pass.
    #[inline(always)]
    pub(super) fn fill<S: Lanes>(&mut self, simd: S, primitives: &[BoxLanes], map: &BinMap<S>) {
        self.clear(0, map.count);
        if primitives.len() < PAIRED_MIN {
            for primitive in primitives {
                self.add(simd, 0, primitive, map);
            }
            return;
        }
        self.clear(1, map.count);
        for pair in primitives.chunks(2) {
            for (set, primitive) in pair.iter().enumerate() {
                self.add(simd, set, primitive, map);
            }
        }
        for axis in 0..3 {
            for bin in 0..map.count {
                let count = self.count(axis, bin) + self.boxes[1][axis][bin].count();
                let other = simd.load8(&self.boxes[1][axis][bin].0);
                let own = &mut self.boxes[0][axis][bin];
                simd.store8(simd.max8(simd.load8(&own.0), other), &mut own.0);
                own.set_count(count);
            }
        }
    }

    #[inline(always)]
    fn clear(&mut self, set: usize, count: usize) {
        for axis in 0..3 {
            self.boxes[set][axis][..count].fill(BoxLanes::EMPTY);
        }
    }

    #[inline(always)]
    fn add<S: Lanes>(&mut self, simd: S, set: usize, primitive: &BoxLanes, map: &BinMap<S>) {
        let bins = map.bins(simd, primitive);
        let bounds = simd.load8(&primitive.0);
        for axis in 0..3 {
            let bin = bins[axis] as usize % MOST_BINS;
            let own = &mut self.boxes[set][axis][bin].0;
            simd.store8(simd.max8_counting(bounds, simd.load8(own)), own);
        }
    }

    #[inline(always)]
    fn bounds<S: Lanes>(&self, simd: S, axis: usize, bin: usize) -> S::F8 {
        simd.load8(&self.boxes[0][axis][bin].0)
    }

    #[inline(always)]
    fn count(&self, axis: usize, bin: usize) -> u32 {
        self.boxes[0][axis][bin].count()
    }

    /// The border at which the sum of both sides' half areas times their numbers is least, if it is below `limit`; of
    /// equal ones the lowest axis, then the highest bin.
    #[inline(always)]
    pub(super) fn best_border<S: Lanes>(&mut self, simd: S, count: usize, scale: S::F4, limit: f32) -> Option<Border> {
        let empty = simd.load8(&BoxLanes::EMPTY.0);
        let (mut best, mut found) = (limit, None);
        for axis in 0..3 {
            let (mut union, mut number) = (empty, 0);
            for bin in 0..count - 1 {
                union = simd.max8(union, self.bounds(simd, axis, bin));
                number += self.count(axis, bin);
                self.below[bin] = number as f32 * half_area(simd, union, scale);
            }
            let (mut union, mut number) = (empty, 0);
            for bin in (1..count).rev() {
                union = simd.max8(union, self.bounds(simd, axis, bin));
                number += self.count(axis, bin);
                // Not a number where a side is empty, and then never less.
                let cost = self.below[bin - 1] + number as f32 * half_area(simd, union, scale);
                if cost < best {
                    best = cost;
                    found = Some(Border { axis, bin });
                }
            }
        }
        found
    }

    /// The boxes around what lies below and above a border.
    #[inline(always)]
    pub(super) fn sides<S: Lanes>(&self, simd: S, count: usize, border: Border) -> [BoxLanes; 2] {
        let mut sides = [BoxLanes::EMPTY; 2];
        for bin in 0..count {
            let side = &mut sides[usize::from(bin >= border.bin)].0;
            let union = simd.max8(self.bounds(simd, border.axis, bin), simd.load8(side));
            simd.store8(union, side);
        }
        sides
    }
}

/// Maps half centers to bins that are uniform over their interval, per axis.
///
/// The map never descends, whatever it rounds; so what it sends below a border has smaller centers than what it sends
/// above. Parting by this map therefore parts by the smallest center above the border, which the dissertation stores in
/// each bin for that purpose, and agrees with the counts in the bins bit for bit.
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
    fn bins(&self, simd: S, primitive: &BoxLanes) -> [i32; 4] {
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
        // A place is never negative, so what is truncated is below just when it is itself; and the border is at most
        // the last bin, so there is no need to end at that.
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
