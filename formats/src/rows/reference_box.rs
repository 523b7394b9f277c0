use crate::geom::{Aabb, round::f32_above};
use bytemuck::{Pod, Zeroable};

/// The fuzzy box of the triangle that the reference of the same row names, rounded outwards to a lattice over the
/// cluster's bounds.
///
/// A coordinate q of an axis stands for `bounds_local.min + q·step` in exact arithmetic, `step` being that of
/// [`box_steps`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ReferenceBoxRow {
    /// Least corner.
    pub min: [u16; 3],
    /// Greatest corner; not below the least.
    pub max: [u16; 3],
}

/// Steps from one end of the lattice to the other.
const STEPS: f64 = u16::MAX as f64;

/// Covers the rounding of a division and a sum in `f64`, relative to the lattice's width.
const F64_SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// Length of a lattice step per axis: 1/65535 of the side of `bounds`, rounded upwards, so that the lattice covers it. Not
/// finite where a side is not.
#[must_use]
pub fn box_steps(bounds: &Aabb) -> [f32; 3] {
    std::array::from_fn(|k| {
        let side = f64::from(bounds.max[k]) - f64::from(bounds.min[k]);
        f32_above(side / STEPS * (1.0 + F64_SLACK))
    })
}

impl ReferenceBoxRow {
    /// The smallest row that contains `fuzzy`, which lies inside of `bounds`.
    #[must_use]
    pub fn around(fuzzy: &Aabb, bounds: &Aabb) -> Self {
        let steps = box_steps(bounds);
        let place = |x: f32, k: usize| (f64::from(x) - f64::from(bounds.min[k])) / f64::from(steps[k]);
        // A side without length has a step of zero: every coordinate stands for its one plane. The casts saturate, and
        // make zero of NaN.
        Self {
            min: std::array::from_fn(|k| (place(fuzzy.min[k], k) * (1.0 - F64_SLACK)).floor() as u16),
            max: std::array::from_fn(|k| (place(fuzzy.max[k], k) * (1.0 + F64_SLACK)).ceil() as u16),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_contain_their_box_and_are_hardly_larger() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from((state >> 40) as u32) / f64::from(1u32 << 24)
        };
        for round in 0..20_000 {
            let (scale, offset) = ([1e-30, 1.0, 1e30][round % 3], [0.0, 1e3, 1e7][round / 3 % 3]);
            let mut interval = |low: f64, high: f64| {
                let (a, b) = (low + random() * (high - low), low + random() * (high - low));
                (a.min(b) as f32, a.max(b) as f32)
            };
            let (mut bounds, mut fuzzy) = (Aabb::EMPTY, Aabb::EMPTY);
            for k in 0..3 {
                (bounds.min[k], bounds.max[k]) = interval(offset * scale, (offset + 1.0) * scale);
                (fuzzy.min[k], fuzzy.max[k]) = interval(f64::from(bounds.min[k]), f64::from(bounds.max[k]));
                fuzzy.min[k] = fuzzy.min[k].clamp(bounds.min[k], bounds.max[k]);
                fuzzy.max[k] = fuzzy.max[k].clamp(fuzzy.min[k], bounds.max[k]);
            }
            let (row, steps) = (ReferenceBoxRow::around(&fuzzy, &bounds), box_steps(&bounds));
            for k in 0..3 {
                let plane = |q: u16| f64::from(bounds.min[k]) + f64::from(q) * f64::from(steps[k]);
                let (min, max) = (plane(row.min[k]), plane(row.max[k]));
                let (low, high) = (f64::from(fuzzy.min[k]), f64::from(fuzzy.max[k]));
                assert!(min <= low && high <= max, "{round}: {min}..{max} around {low}..{high}");
                let width = 2.1 * f64::from(steps[k]);
                assert!(
                    low - min <= width && max - high <= width,
                    "{round}: {min}..{max} around {low}..{high}"
                );
            }
        }
    }
}
