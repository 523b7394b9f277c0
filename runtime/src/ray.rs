use bytemuck::{Pod, Zeroable};

/// A ray: the points `origin + t · direction` with `t_min ≤ t ≤ t_max`.
///
/// The direction need not be normalised; `t` counts in its lengths. A ray with a NaN or infinite origin or direction,
/// a zero direction, a NaN bound or `t_min > t_max` hits nothing. Infinite bounds are allowed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// World space.
    pub origin: [f32; 3],
    /// World space, any length above zero.
    pub direction: [f32; 3],
    /// Least `t` that counts as a hit.
    pub t_min: f32,
    /// Greatest `t` that counts as a hit.
    pub t_max: f32,
}

impl Ray {
    /// The ray from `origin` with no far end.
    #[must_use]
    pub const fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self {
            origin,
            direction,
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    /// The segment between two points: `t` runs from 0 at `from` to 1 at `to`.
    #[must_use]
    pub fn between(from: [f32; 3], to: [f32; 3]) -> Self {
        Self {
            origin: from,
            direction: std::array::from_fn(|k| to[k] - from[k]),
            t_min: 0.0,
            t_max: 1.0,
        }
    }

    /// True when the ray can hit anything at all.
    pub(crate) fn is_usable(&self) -> bool {
        self.origin.iter().chain(&self.direction).all(|x| x.is_finite())
            && self.direction.iter().any(|x| *x != 0.0)
            && self.t_min <= self.t_max
    }
}
