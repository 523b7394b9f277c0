//! The ray–triangle test: watertight, in world space, the same for every caller.
//!
//! Based on: Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013.
//!
//! Differs: their test evaluates the edge functions in `f32` and repeats in `f64` where one is zero. Here the `f32`
//! edge functions only reject, and `f64` ones decide. Of two products of `f32` numbers the rounded difference has the
//! sign of the exact one unless it is zero, so the rejection is exact; and in `f64` the products themselves are exact,
//! so each edge function, and with it each barycentric weight, is right to 2⁻⁵³ **relatively**, however grazing the
//! ray. What error remains is that of the sheared vertices, [`VERTEX_ERROR`], and of `t`'s rounding to `f32`; the
//! traversal's margins rest on exactly these two.

use crate::{Ray, affine64::wide};

/// A hit is an exact hit of the ray with a triangle whose corners are each moved by at most this factor times
/// `max |corner − origin|∞` per axis.
///
/// Derivation, with u = 2⁻²⁴ and D the maximum: subtracting the origin moves a coordinate by u·D; the shear constant
/// is off by a factor 1 + u, its product by 1 + u, and |shear| ≤ 1, so 2u·D; the last subtraction rounds a number of
/// at most 2D. Together 5u·D and terms in u²; one u covers those.
pub const VERTEX_ERROR: f64 = 6.0 * restpose_formats::geom::round::UNIT_ROUNDOFF;

/// What the test needs of a ray, computed once.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    origin: [f32; 3],
    /// Axis along which the direction is longest, and the two others.
    axes: [usize; 3],
    shear: [f32; 2],
    direction_z: f64,
    t_min: f32,
    t_max: f32,
}

/// A hit without the names of what was hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

impl PreparedRay {
    /// Prepares a ray; `None` when it can hit nothing (see [`Ray`]).
    #[inline]
    #[must_use]
    pub fn new(ray: &Ray) -> Option<Self> {
        if !ray.is_usable() {
            return None;
        }
        let d = ray.direction;
        let z = (1..3).fold(0, |best, k| if d[k].abs() > d[best].abs() { k } else { best });
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        Some(Self {
            origin: ray.origin,
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z]],
            direction_z: f64::from(d[z]),
            t_min: ray.t_min,
            t_max: ray.t_max,
        })
    }

    /// Tests one triangle, from both sides, edges and corners included.
    ///
    /// Guarantee: triangles that share an edge leave no gap along it, because equal corners are sheared to equal
    /// numbers and each edge function's sign is exact. A triangle seen exactly edge-on, or without area, is not hit.
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, corners: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        let [a, b, c] = [self.shear(corners[0]), self.shear(corners[1]), self.shear(corners[2])];

        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }

        let (a, b, c) = (wide(a), wide(b), wide(c));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let depth = ((u * a[2] + v * b[2]) + w * c[2]) / determinant;
        // Adding zero turns −0 into +0: equal distances have equal bits.
        let t = (depth / self.direction_z) as f32 + 0.0;
        if !t.is_finite() || t < self.t_min || t > self.t_max {
            return None;
        }
        Some(TriangleHit {
            t,
            u: (v / determinant) as f32,
            v: (w / determinant) as f32,
        })
    }

    /// The corner relative to the origin, sheared so that the ray runs along the third axis.
    #[inline(always)]
    fn shear(&self, corner: [f32; 3]) -> [f32; 3] {
        let along = |axis: usize| corner[axis] - self.origin[axis];
        let z = along(self.axes[2]);
        [
            along(self.axes[0]) - self.shear[0] * z,
            along(self.axes[1]) - self.shear[1] * z,
            z,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(ray: Ray, corners: [[f32; 3]; 3]) -> Option<TriangleHit> {
        PreparedRay::new(&ray)?.intersect(&corners)
    }

    const UNIT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn weights_belong_to_the_second_and_third_corner() {
        let found = hit(Ray::new([0.25, 0.5, 2.0], [0.0, 0.0, -4.0]), UNIT).unwrap();
        assert_eq!(
            found,
            TriangleHit {
                t: 0.5,
                u: 0.25,
                v: 0.5
            }
        );
        let from_behind = hit(Ray::new([0.25, 0.5, -2.0], [0.0, 0.0, 4.0]), UNIT).unwrap();
        assert_eq!(from_behind, found);
    }

    #[test]
    fn corners_and_edges_count_and_the_outside_does_not() {
        let down = |x, y| hit(Ray::new([x, y, 1.0], [0.0, 0.0, -1.0]), UNIT).is_some();
        assert!(down(0.0, 0.0) && down(1.0, 0.0) && down(0.0, 1.0) && down(0.5, 0.5) && down(0.5, 0.0));
        assert!(!down(0.5f32.next_up(), 0.5) && !down(0.5, 0.0f32.next_down()) && !down(1.5, 0.5));
    }

    #[test]
    fn range_is_closed() {
        let with = |t_min, t_max| {
            hit(
                Ray {
                    t_min,
                    t_max,
                    ..Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])
                },
                UNIT,
            )
            .is_some()
        };
        assert!(with(1.0, 1.0) && with(0.0, 1.0) && with(1.0, f32::INFINITY) && with(f32::NEG_INFINITY, 1.0));
        assert!(!with(1.0f32.next_up(), 2.0) && !with(0.0, 1.0f32.next_down()) && !with(2.0, 0.5));
        assert!(!with(f32::NAN, 2.0) && !with(0.0, f32::NAN));
    }

    #[test]
    fn edge_on_and_degenerate_triangles_are_not_hit() {
        assert_eq!(hit(Ray::new([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), UNIT), None);
        let point = [[0.3, 0.3, 0.0]; 3];
        assert_eq!(hit(Ray::new([0.3, 0.3, 1.0], [0.0, 0.0, -1.0]), point), None);
        let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(hit(Ray::new([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]), line), None);
    }

    #[test]
    fn rays_that_cannot_hit_are_refused() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(PreparedRay::new(&Ray::new([0.0, bad, 0.0], [1.0, 0.0, 0.0])).is_none());
            assert!(PreparedRay::new(&Ray::new([0.0; 3], [1.0, bad, 0.0])).is_none());
        }
        assert!(PreparedRay::new(&Ray::new([0.0; 3], [0.0, -0.0, 0.0])).is_none());
    }

    #[test]
    fn tiny_and_huge_triangles_are_hit_alike() {
        for exponent in [-100, -60, -30, 0, 30, 60, 100] {
            let scale = 2.0f32.powi(exponent);
            let corners = UNIT.map(|p| p.map(|x| x * scale));
            let ray = Ray::new([0.25 * scale, 0.25 * scale, scale], [0.0, 0.0, -scale]);
            assert_eq!(
                hit(ray, corners),
                Some(TriangleHit {
                    t: 1.0,
                    u: 0.25,
                    v: 0.25
                }),
                "scale 2^{exponent}"
            );
        }
    }
}
