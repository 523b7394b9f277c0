use super::SlabRay;
use restpose_formats::{geom::Aabb, rows::ReferenceBoxRow};

/// A ray ready for the boxes of single triangles: where along it the planes of a cluster's lattice lie.
///
/// Of the two planes of an axis, `near` is the one that the ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LatticeRay {
    /// `t` per lattice step.
    pub rate: [f32; 3],
    /// `t` of the lattice's zero, widened for near planes.
    pub near: [f32; 3],
    /// The same for far planes.
    pub far: [f32; 3],
    /// Whether the ray runs with the axis.
    pub forward: [bool; 3],
}

impl LatticeRay {
    /// Stands where no ray is.
    pub(crate) const NONE: Self = Self {
        rate: [0.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        forward: [true; 3],
    };

    /// `steps` are those of [`restpose_formats::rows::box_steps`]; planes may be a fourteenth of the lattice beyond its ends, as
    /// those between two keys. Along an axis where a plane's `t` could overflow, or
    /// its rate is so small that rounding is no longer relative to it, boxes restrict nothing.
    #[inline(always)]
    pub(crate) fn new(ray: &SlabRay, bounds: &Aabb, steps: &[f32; 3]) -> Self {
        Self::within(ray, bounds.min, *steps, f32::from(u16::MAX))
    }

    /// As [`LatticeRay::new`], for planes that are up to so many steps from the lattice's zero.
    #[inline(always)]
    pub(crate) fn within(ray: &SlabRay, zero: [f32; 3], steps: [f32; 3], most_steps: f32) -> Self {
        let forward = ray.inverse_direction.map(f32::is_sign_positive);
        let plane = |k: usize, towards_max: bool| {
            let relative = zero[k] - ray.origin[k];
            let widened = if towards_max {
                relative + ray.margin[k]
            } else {
                relative - ray.margin[k]
            };
            widened * ray.inverse_direction[k]
        };
        let mut out = Self {
            rate: std::array::from_fn(|k| steps[k] * ray.inverse_direction[k]),
            near: std::array::from_fn(|k| plane(k, !forward[k])),
            far: std::array::from_fn(|k| plane(k, forward[k])),
            forward,
        };
        for k in 0..3 {
            let rate = out.rate[k].abs();
            let small = |t: f32| t.abs() < f32::MAX / 4.0;
            let in_range = small(out.near[k]) && small(out.far[k]) && small(most_steps * rate);
            let precise = rate >= f32::MIN_POSITIVE || steps[k] == 0.0;
            if !(in_range && precise) {
                out.rate[k] = f32::NAN;
            }
        }
        out
    }

    /// Whether the ray may be inside the box within `range`. A NaN restricts nothing.
    #[inline]
    pub(crate) fn meets(&self, bounds: &ReferenceBoxRow, range: (f32, f32)) -> bool {
        let (mut enter, mut exit) = range;
        for k in 0..3 {
            let (near, far) = if self.forward[k] {
                (bounds.min[k], bounds.max[k])
            } else {
                (bounds.max[k], bounds.min[k])
            };
            let near = f32::from(near) * self.rate[k] + self.near[k];
            let far = f32::from(far) * self.rate[k] + self.far[k];
            enter = if near > enter { near } else { enter };
            exit = if far < exit { far } else { exit };
        }
        enter <= exit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster_frame::SMALLEST_NORMAL;
    use restpose_formats::geom::round::{UNIT_ROUNDOFF, f32_above};

    /// Points on a ray, in boxes on the lattice that hold nothing else: all are met, at any scale of box and direction.
    #[test]
    fn a_box_around_a_point_of_the_ray_is_met() {
        let mut random = fastrand::Rng::with_seed(5);
        for round in 0..200_000 {
            let mut exponent = |range: i32| (random.f64() * 2.0 - 1.0) * f64::from(range);
            let (size, speed) = (exponent(36), exponent(37));
            let (size, speed) = (10f64.powf(size), 10f64.powf(speed));
            let mut signed = || random.f64() * 2.0 - 1.0;
            let point: [f64; 3] = std::array::from_fn(|_| signed() * size);
            let direction: [f32; 3] = std::array::from_fn(|_| {
                let d = signed();
                if d.abs() < 0.1 { 0.0 } else { (d * speed) as f32 }
            });
            let far = 4.0 * size / speed * signed();
            let origin: [f32; 3] = std::array::from_fn(|k| (point[k] - far * f64::from(direction[k])) as f32);
            let bounds = Aabb {
                min: [(-size) as f32; 3],
                max: [size as f32; 3],
            };
            if !origin
                .iter()
                .chain(&bounds.max)
                .all(|x| x.is_finite() && x.abs() < 1e37)
            {
                continue;
            }
            let fuzzy = Aabb::around([point.map(|x| x as f32)]);
            let margin = std::array::from_fn(|k: usize| {
                let reach = f64::from(origin[k].abs()) + 6.0 * size;
                f32_above(64.0 * UNIT_ROUNDOFF * reach + 2.0 * SMALLEST_NORMAL * (1.0 + speed))
            });
            let ray = SlabRay {
                origin,
                inverse_direction: std::array::from_fn(|k| 1.0 / direction[k]),
                margin,
            };
            let lattice = LatticeRay::new(&ray, &bounds, &restpose_formats::rows::box_steps(&bounds));
            let row = ReferenceBoxRow::around(&fuzzy, &bounds);
            let limit = [f32::INFINITY, f32::MAX][round % 2];
            assert!(
                lattice.meets(&row, (-limit, limit)),
                "round {round}: {ray:?} {bounds:?} {fuzzy:?}"
            );
        }
    }
}
