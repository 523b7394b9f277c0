use super::{colour::Colour, corner_fans::CornerFans, surroundings::Surroundings};
use glam::Vec3;
use restpose_formats::geom::round::gamma;
use restpose_runtime::{Frame, Hit, InstanceId, Ray};

/// Roundings between the corners of a posed triangle and the decision of a shadow ray that starts on it: seven for the
/// point (three products, two sums, `1 − u − v` in two), and nine for the distance at which the triangle test meets
/// the same plane again (the corners relative to the ray, the shear, the weighted sum and its division).
const SHADOW_ROUNDINGS: u32 = 16;

/// Least `t` of a shadow ray: any but zero. A triangle in an axis plane through the origin has no rounding at all, and
/// the ray that starts on it would meet it at exactly zero.
const SHADOW_T_MIN: f32 = f32::MIN_POSITIVE;

/// Shades the points of one frame. A frame's triangles are posed once for their normals: a picture sees most of them.
pub struct Shading<'a> {
    frame: Frame<'a>,
    fans: &'a CornerFans,
    around: &'a Surroundings,
    area_normals: &'a [Vec3],
}

/// Normals of all triangles of an instance in this frame, with the area as length; zero where there is none.
pub fn area_normals(frame: &Frame<'_>, instance: InstanceId, triangle_count: u32) -> Vec<Vec3> {
    use rayon::prelude::*;
    let normal = |triangle| {
        let corners = frame.triangle(instance, triangle)?;
        Some(face_normal(&corners.map(Vec3::from))).filter(|normal| normal.is_finite())
    };
    (0..triangle_count)
        .into_par_iter()
        .with_min_len(256)
        .map(|triangle| normal(triangle).unwrap_or_default())
        .collect()
}

impl<'a> Shading<'a> {
    /// Shading for one frame.
    pub fn new(frame: Frame<'a>, fans: &'a CornerFans, around: &'a Surroundings, area_normals: &'a [Vec3]) -> Self {
        Self {
            frame,
            fans,
            around,
            area_normals,
        }
    }

    /// The colour that `ray` sees where it meets a surface of `own_colour`.
    pub fn surface(&self, ray: &Ray, hit: &Hit, own_colour: Colour) -> Colour {
        let Some(corners) = self.frame.triangle(hit.instance, hit.triangle) else {
            return own_colour;
        };
        let corners = corners.map(Vec3::from);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let point: Vec3 = mix(&corners, &weights);
        // Surfaces have two sides: normals are turned towards the eye.
        let winding = face_normal(&corners).normalize_or(Vec3::Y);
        let facing = if winding.dot(ray.direction.into()) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let face = winding * facing;
        let corner_normals = self
            .fans
            .corner_normals(hit.triangle, self.area_normals, winding)
            .map(|normal| normal * facing);
        let normal = mix(&corner_normals, &weights).normalize_or(face);
        let sunlit = normal.dot(self.around.light()) > 0.0 && {
            let start = rounded_surface(point, &corners, &corner_normals, &weights);
            self.sees_light(start + face * rounding(&corners, face))
        };
        self.around.reflected(own_colour, normal, sunlit)
    }

    /// The colour that `ray` sees where it meets nothing of the model: the floor with its shadow, or the sky.
    pub fn background(&self, ray: &Ray) -> Colour {
        let direction = Vec3::from(ray.direction);
        match self.around.meet_floor(ray) {
            Some(at) => self.around.floor_colour(&at, direction, self.sees_light(at.point)),
            None => self.around.sky(direction),
        }
    }

    fn sees_light(&self, from: Vec3) -> bool {
        let ray = Ray {
            t_min: SHADOW_T_MIN,
            ..Ray::new(from.to_array(), self.around.light().to_array())
        };
        !self.frame.any_hit(&ray)
    }
}

fn face_normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (*b - *a).cross(*c - *a)
}

fn mix(of: &[Vec3; 3], weights: &[f32; 3]) -> Vec3 {
    of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2]
}

/// How far along `normal` a point on the triangle must be moved to lie surely on that side of it, in scene units.
fn rounding(corners: &[Vec3; 3], normal: Vec3) -> f32 {
    let largest = corners
        .iter()
        .fold(Vec3::ZERO, |largest, corner| largest.max(corner.abs()));
    largest.dot(normal.abs()) * gamma(SHADOW_ROUNDINGS) as f32
}

/// The point lifted from the flat triangle to the round surface that the normals suggest, so that the triangle does not
/// throw a shadow on itself where the surface it stands for would not.
///
/// Source: Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II (2021), chapter 4.
fn rounded_surface(point: Vec3, corners: &[Vec3; 3], normals: &[Vec3; 3], weights: &[f32; 3]) -> Vec3 {
    // Only outwards: where the surface is hollow the flat triangle is already in front.
    let lifts: [Vec3; 3] = std::array::from_fn(|k| normals[k] * -(point - corners[k]).dot(normals[k]).min(0.0));
    point + mix(&lifts, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn a_flat_triangle_is_not_lifted_and_a_round_one_is_lifted_outwards() {
        let weights = [0.4, 0.3, 0.3];
        let point = mix(&CORNERS, &weights);
        assert_eq!(rounded_surface(point, &CORNERS, &[Vec3::Z; 3], &weights), point);
        let bulging = [
            Vec3::new(-0.3, -0.3, 0.9),
            Vec3::new(0.4, 0.0, 0.9),
            Vec3::new(0.0, 0.4, 0.9),
        ];
        assert!(rounded_surface(point, &CORNERS, &bulging, &weights).z > 0.01);
        let hollow = bulging.map(|normal| normal * Vec3::new(-1.0, -1.0, 1.0));
        assert_eq!(rounded_surface(point, &CORNERS, &hollow, &weights), point);
    }

    #[test]
    fn the_rounding_grows_with_the_coordinates() {
        let near = rounding(&CORNERS, Vec3::Z);
        let far = rounding(&CORNERS.map(|corner| corner + Vec3::splat(1000.0)), Vec3::Z);
        assert_eq!(near, 0.0);
        // Sixteen roundings of 2⁻²⁴ at 1000 are about 0.00095.
        assert!(far > 9e-4 && far < 1e-3);
    }
}
