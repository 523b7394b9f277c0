use super::bvh::BvhSettings;
use super::bvh_bins::{BinCount, BinMap, Bins};
use super::bvh_few::{FEW, split_few};
use super::bvh_primitive::{BoxLanes, around, half_area};
use crate::simd::Lanes;

/// Where a list of primitives was parted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    /// Primitives of the left child, which stand first.
    pub left: usize,
    /// Boxes of both children.
    pub bounds: [BoxLanes; 2],
}

/// Parts `primitives`, two or more, by the cheapest border between bins; `None` when they are better left together by
/// Eq. 4.3.
#[inline(always)]
pub(super) fn split<S: Lanes>(
    simd: S,
    primitives: &mut [BoxLanes],
    bounds: &BoxLanes,
    count: BinCount,
    settings: &BvhSettings,
    bins: &mut Bins,
) -> Option<Split> {
    let number = primitives.len() as f32;
    let scale = simd.splat4(unit_scale(simd, bounds)?);
    let whole = half_area(simd, simd.load8(&bounds.0), scale);
    // K_Trav + K_Isec · (cost / area) < K_Isec · n, solved for the cost.
    let saved = settings.traversal_cost / settings.intersection_cost;
    let limit = (number - saved as f32) * whole;
    if primitives.len() <= FEW {
        return split_few(simd, primitives, bounds, scale, limit);
    }
    let count = count.of(primitives.len());
    let map = BinMap::new(simd, primitives, count);
    bins.fill(simd, primitives, &map);
    let border = bins.best_border(simd, count, scale, limit)?;
    let bounds = bins.sides(simd, count, border);
    let left = map.part(simd, primitives, border);
    Some(Split { left, bounds })
}

/// Parts `primitives`, two or more, into equal halves, by centers along the longest side of `bounds`.
#[inline(always)]
pub(super) fn halve<S: Lanes>(simd: S, primitives: &mut [BoxLanes], bounds: &BoxLanes) -> Split {
    let left = primitives.len() / 2;
    let side = |axis: usize| f64::from(bounds.0[4 + axis]) + f64::from(bounds.0[axis]);
    let axis = (1..3).fold(0, |widest, axis| if side(axis) > side(widest) { axis } else { widest });
    primitives.select_nth_unstable_by(left, |a, b| {
        a.half_center_along(axis).total_cmp(&b.half_center_along(axis))
    });
    let (below, above) = primitives.split_at(left);
    Split {
        left,
        bounds: [around(simd, below), around(simd, above)],
    }
}

/// A power of two that brings the longest side of `bounds` near one, so that no area overflows, and none vanishes that
/// is not far smaller than that of `bounds`; `None` for a point.
#[inline(always)]
pub(super) fn unit_scale<S: Lanes>(simd: S, bounds: &BoxLanes) -> Option<f32> {
    let half = simd.splat4(0.5);
    let [negated_min, max] = simd.halves(simd.load8(&bounds.0));
    let [x, y, z, _] = simd.store4(simd.add4(simd.mul4(max, half), simd.mul4(negated_min, half)));
    let longest = x.max(y).max(z);
    let exponent = (longest.to_bits() >> 23).clamp(1, 253);
    (longest > 0.0).then(|| f32::from_bits((254 - exponent) << 23))
}
