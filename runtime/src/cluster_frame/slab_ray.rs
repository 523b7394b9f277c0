use super::{UNDERFLOW_FLOOR, WORLD_RAY_ERROR};
use restpose_formats::geom::Aabb;

/// A ray ready for slab tests and kd-tree steps: the space it is in, and by how much planes are widened there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay {
    pub origin: [f32; 3],
    pub inverse_direction: [f32; 3],
    /// Each plane counts from this much before it to this much behind it.
    pub margin: [f32; 3],
}

/// Eight rays, lane by lane, without their margins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabLanes {
    pub origin: [[f32; 8]; 3],
    pub inverse_direction: [[f32; 8]; 3],
}

impl SlabLanes {
    pub(crate) const NONE: Self = Self {
        origin: [[0.0; 8]; 3],
        inverse_direction: [[0.0; 8]; 3],
    };
}

/// The greatest distance per axis from `origin` to a point of `bounds`.
pub(super) fn distance(origin: [f32; 3], bounds: &Aabb) -> f32 {
    (0..3).fold(0.0, |far: f32, k| {
        far.max(bounds.max[k] - origin[k]).max(origin[k] - bounds.min[k])
    })
}

impl SlabRay {
    /// The ray in world space, with the margin that boxes inside `bounds` need (points 5 and 7).
    pub(crate) fn in_world(origin: [f32; 3], direction: [f32; 3], bounds: &Aabb) -> Self {
        let margin = WORLD_RAY_ERROR * distance(origin, bounds) + UNDERFLOW_FLOOR as f32;
        Self {
            origin,
            inverse_direction: std::array::from_fn(|k| 1.0 / direction[k]),
            margin: [margin; 3],
        }
    }

    /// Where the ray may be inside `bounds`, within `range`; `None` when it is nowhere.
    ///
    /// Comparisons are written so that a NaN (a ray in the plane of a face, an overflown margin) restricts nothing.
    #[inline]
    pub(crate) fn clip(&self, bounds: &Aabb, range: (f32, f32)) -> Option<(f32, f32)> {
        let (mut enter, mut exit) = range;
        for k in 0..3 {
            let low = ((bounds.min[k] - self.origin[k]) - self.margin[k]) * self.inverse_direction[k];
            let high = ((bounds.max[k] - self.origin[k]) + self.margin[k]) * self.inverse_direction[k];
            let (near, far) = if self.inverse_direction[k].is_sign_positive() {
                (low, high)
            } else {
                (high, low)
            };
            if near > enter {
                enter = near;
            }
            if far < exit {
                exit = far;
            }
        }
        (enter <= exit).then_some((enter, exit))
    }
}
