use super::{F64_SLACK, PosedMap, UNDERFLOW_FLOOR};
use crate::simd::{Four, four};
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
    pub(super) fn world_box(&self, map: &PosedMap, reach: Four, error: Four) -> Aabb {
        let [x, y, z, offset] = map.columns();
        let ([a, b, c], [s, t, u]) = (self.center, self.half);
        let middle = four(|k| x[k] * a + y[k] * b + z[k] * c + offset[k]);
        let spread = four(|k| x[k].abs() * s + y[k].abs() * t + z[k].abs() * u);
        let spread = four(|k| spread[k] + error[k] + F64_SLACK * reach[k]);
        let (least, greatest) = (four(|k| middle[k] - spread[k]), four(|k| middle[k] + spread[k]));
        Aabb {
            min: [f32_below(least[0]), f32_below(least[1]), f32_below(least[2])],
            max: [f32_above(greatest[0]), f32_above(greatest[1]), f32_above(greatest[2])],
        }
    }
}

/// World box of what lies in `bounds` before `map`, in exact arithmetic, where vertices are off by `vertex_error` after it.
pub(crate) fn world_box(bounds: &Aabb, map: &PosedMap, vertex_error: Four) -> Aabb {
    let bounds = Extents::new(bounds);
    let reach = map.reach(bounds.reach);
    let error = four(|k| vertex_error[k] + UNIT_ROUNDOFF * reach[k] + UNDERFLOW_FLOOR);
    bounds.world_box(map, reach, error)
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
