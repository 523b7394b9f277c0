use super::{F64_SLACK, PosedMap, UNDERFLOW_FLOOR};
use crate::simd::{Doubles, Lanes, weighted_sum};
use restpose_formats::geom::{
    Aabb,
    round::{UNIT_ROUNDOFF, f32_above, f32_below},
};

/// A box by its middle and half its sides, in `f64`.
pub(super) struct Extents {
    center: [f64; 3],
    half: [f64; 3],
    /// Greatest magnitude per axis.
    pub reach: [f64; 3],
}

impl Extents {
    #[inline(always)]
    pub(super) fn new(bounds: &Aabb) -> Self {
        let mut out = Self {
            center: [0.0; 3],
            half: [0.0; 3],
            reach: [0.0; 3],
        };
        for k in 0..3 {
            let (min, max) = (f64::from(bounds.min[k]), f64::from(bounds.max[k]));
            out.center[k] = 0.5 * (min + max);
            out.half[k] = 0.5 * (max - min);
            out.reach[k] = min.abs().max(max.abs());
        }
        out
    }

    /// The box widened by `excess` on both sides of each axis.
    #[inline(always)]
    pub(super) fn widened(mut self, excess: [f64; 3]) -> Self {
        for k in 0..3 {
            self.half[k] += excess[k];
            self.reach[k] += excess[k];
        }
        self
    }

    /// The box around the image of this one, widened by `error`; `reach` is the map's [reach](PosedMap::reach) of it.
    #[inline(always)]
    pub(super) fn world_box<S: Lanes>(&self, simd: S, map: &PosedMap, reach: Doubles<S>, error: Doubles<S>) -> Aabb {
        let [x, y, z, offset] = map.columns(simd);
        let middle = weighted_sum([x, y, z], self.center) + offset;
        let spread = weighted_sum([x.abs(), y.abs(), z.abs()], self.half);
        let spread = spread + error + reach * F64_SLACK;
        let (least, greatest) = ((middle - spread).numbers(), (middle + spread).numbers());
        Aabb {
            min: [f32_below(least[0]), f32_below(least[1]), f32_below(least[2])],
            max: [f32_above(greatest[0]), f32_above(greatest[1]), f32_above(greatest[2])],
        }
    }
}

/// World box of what lies in `bounds` before `map`, in exact arithmetic, where vertices are off by `vertex_error` after it.
#[inline(always)]
pub(crate) fn world_box<S: Lanes>(simd: S, bounds: &Aabb, map: &PosedMap, vertex_error: Doubles<S>) -> Aabb {
    let bounds = Extents::new(bounds);
    let reach = map.reach(simd, bounds.reach);
    let error = vertex_error + reach * UNIT_ROUNDOFF + Doubles::splat(simd, UNDERFLOW_FLOOR);
    bounds.world_box(simd, map, reach, error)
}

/// What two boxes that both contain something have in common.
#[inline(always)]
pub(super) fn overlap(a: Aabb, b: Aabb) -> Aabb {
    let mut out = a;
    for k in 0..3 {
        let (min, max) = (a.min[k].max(b.min[k]), a.max[k].min(b.max[k]));
        if min <= max {
            (out.min[k], out.max[k]) = (min, max);
        }
    }
    out
}
