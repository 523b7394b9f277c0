use super::bvh_primitive::BoxLanes;
use crate::simd::Lanes;

/// Eight boxes, side by side: −min.x, −min.y, −min.z, max.x, max.y, max.z.
#[derive(Clone, Copy)]
pub(super) struct EightBoxes<S: Lanes>(pub [S::F8; 6]);

impl<S: Lanes> EightBoxes<S> {
    /// From what eight [`BoxLanes`] hold.
    #[inline(always)]
    pub(super) fn new(simd: S, boxes: [S::F8; 8]) -> Self {
        let [a, b, c, _, d, e, f, _] = simd.transpose8(boxes);
        Self([a, b, c, d, e, f])
    }

    #[inline(always)]
    pub(super) fn load(simd: S, boxes: &[BoxLanes; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = boxes;
        Self::new(
            simd,
            [
                simd.load8(&a.0),
                simd.load8(&b.0),
                simd.load8(&c.0),
                simd.load8(&d.0),
                simd.load8(&e.0),
                simd.load8(&f.0),
                simd.load8(&g.0),
                simd.load8(&h.0),
            ],
        )
    }

    /// Those in which `counted` is infinite; boxes where it is minus infinity become empty.
    #[inline(always)]
    pub(super) fn only(self, simd: S, counted: S::F8) -> Self {
        let mut sides = self.0;
        for side in &mut sides {
            *side = simd.min8(*side, counted);
        }
        Self(sides)
    }

    #[inline(always)]
    pub(super) fn permuted(self, simd: S, order: S::F8) -> Self {
        let mut sides = self.0;
        for side in &mut sides {
            *side = simd.permute8(*side, order);
        }
        Self(sides)
    }

    /// Half of the centers along an axis.
    #[inline(always)]
    pub(super) fn half_centers(&self, simd: S, axis: usize) -> S::F8 {
        let quarter = simd.splat8(0.25);
        simd.sub8(simd.mul8(self.0[3 + axis], quarter), simd.mul8(self.0[axis], quarter))
    }

    /// No boxes.
    #[inline(always)]
    pub(super) fn empty(simd: S) -> Self {
        Self([simd.splat8(f32::NEG_INFINITY); 6])
    }

    /// Each with those before it.
    #[inline(always)]
    pub(super) fn joined_below(self, simd: S) -> Self {
        let mut sides = self.0;
        for side in &mut sides {
            *side = simd.max8(*side, simd.later8::<1>(*side));
            *side = simd.max8(*side, simd.later8::<2>(*side));
            *side = simd.max8(*side, simd.later8::<4>(*side));
        }
        Self(sides)
    }

    /// Each with those behind it.
    #[inline(always)]
    pub(super) fn joined_above(self, simd: S) -> Self {
        let mut sides = self.0;
        for side in &mut sides {
            *side = simd.max8(*side, simd.sooner8::<1>(*side));
            *side = simd.max8(*side, simd.sooner8::<2>(*side));
            *side = simd.max8(*side, simd.sooner8::<4>(*side));
        }
        Self(sides)
    }

    /// Each with the one of the same number.
    #[inline(always)]
    pub(super) fn joined(self, simd: S, other: Self) -> Self {
        let mut sides = self.0;
        for (side, other) in sides.iter_mut().zip(other.0) {
            *side = simd.max8(*side, other);
        }
        Self(sides)
    }

    /// Eight times that of a number.
    #[inline(always)]
    pub(super) fn only_lane(self, simd: S, lane: u32) -> Self {
        self.permuted(simd, simd.splat8(f32::from_bits(lane)))
    }

    /// As [`half_area`](super::bvh_primitive::half_area).
    #[inline(always)]
    pub(super) fn half_areas(&self, simd: S, scale: S::F8) -> S::F8 {
        let [a, b, c, d, e, f] = self.0;
        let x = simd.add8(simd.mul8(d, scale), simd.mul8(a, scale));
        let y = simd.add8(simd.mul8(e, scale), simd.mul8(b, scale));
        let z = simd.add8(simd.mul8(f, scale), simd.mul8(c, scale));
        simd.add8(simd.add8(simd.mul8(x, y), simd.mul8(y, z)), simd.mul8(z, x))
    }

    /// What parting between these boxes costs: in lane `i`, half the area around boxes 0 to `i − 1` times `below[i]`, plus
    /// that around the others times `above[i]`. Lane 0 and those in which a side is empty are infinite.
    #[inline(always)]
    pub(super) fn border_costs(&self, simd: S, below: S::F8, above: S::F8, scale: S::F8) -> S::F8 {
        let lower = simd.later8::<1>(self.joined_below(simd).half_areas(simd, scale));
        let upper = self.joined_above(simd).half_areas(simd, scale);
        let cost = simd.add8(simd.mul8(lower, below), simd.mul8(upper, above));
        // Where a side is empty this is no number, or infinite.
        let cost = simd.min8(cost, simd.splat8(f32::INFINITY));
        simd.max8(cost, simd.load8(&FIRST))
    }
}

const FIRST: [f32; 8] = {
    let mut lanes = [f32::NEG_INFINITY; 8];
    lanes[0] = f32::INFINITY;
    lanes
};

/// The lowest of eight numbers.
#[inline(always)]
pub(super) fn lowest<S: Lanes>(simd: S, numbers: S::F8) -> f32 {
    let least = simd.min8(numbers, simd.later8::<4>(numbers));
    let least = simd.min8(least, simd.later8::<2>(least));
    let least = simd.min8(least, simd.later8::<1>(least));
    let mut lanes = [0.0; 8];
    simd.store8(least, &mut lanes);
    lanes[7]
}

/// The lowest of three lists of costs, with its axis and lane, if it is below `limit`: of equal ones that of the lowest axis, and
/// there the last.
#[inline(always)]
pub(super) fn cheapest<S: Lanes>(simd: S, costs: &[S::F8; 3], limit: f32) -> Option<(f32, usize, usize)> {
    let best = lowest(simd, simd.min8(simd.min8(costs[0], costs[1]), costs[2]));
    if best < limit {
        for (axis, costs) in costs.iter().enumerate() {
            let found = simd.le8(*costs, simd.splat8(best));
            if found != 0 {
                return Some((best, axis, found.ilog2() as usize));
            }
        }
    }
    None
}
