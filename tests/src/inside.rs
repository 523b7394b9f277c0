//! Whether points are inside of closed surfaces, and how far from them.

use nalgebra::Vector3;
use restpose_runtime::Aabb;

/// A posed triangle.
pub type Corners = [[f32; 3]; 3];

/// How many times a closed surface winds around a point that is not on it: the sum of the solid angles of its triangles
/// over 4π, in `f64`.
///
/// Source: van Oosterom, Strackee, *The Solid Angle of a Plane Triangle*, 1983, Eq. 8.
#[must_use]
pub fn winding_number(triangles: &[Corners], point: [f32; 3]) -> f64 {
    let angle = |corners: &Corners| {
        let [a, b, c] = corners.map(|corner| vector(corner) - vector(point));
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// The distance from a point to the nearest triangle, in `f64`.
#[must_use]
pub fn distance_to(triangles: &[Corners], point: [f32; 3]) -> f64 {
    let least = |corners: &Corners| {
        let corners = corners.map(vector);
        let p = vector(point);
        let along = |a: Vector3<f64>, b: Vector3<f64>| {
            let edge = b - a;
            let s = (p - a).dot(&edge) / edge.norm_squared();
            (a + edge * s.clamp(0.0, 1.0) - p).norm()
        };
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let beside = |a: Vector3<f64>, b: Vector3<f64>| (b - a).cross(&(p - a)).dot(&normal) >= 0.0;
        if beside(a, b) && beside(b, c) && beside(c, a) && normal.norm() > 0.0 {
            ((p - a).dot(&normal) / normal.norm()).abs()
        } else {
            // Of an edge without length the ends are compared: `min` takes no NaN.
            [(a, b), (b, c), (c, a)]
                .iter()
                .fold((a - p).norm(), |least, (a, b)| least.min(along(*a, *b)))
        }
    };
    triangles.iter().map(least).fold(f64::INFINITY, f64::min)
}

/// Whether a closed surface winds around a point, and is at least `clearance` away from it.
#[must_use]
pub fn is_inside(triangles: &[Corners], point: [f32; 3], clearance: f64) -> bool {
    winding_number(triangles, point).abs() > 0.5 && distance_to(triangles, point) >= clearance
}

/// The longest side of the box around triangles.
#[must_use]
pub fn size(triangles: &[Corners]) -> f64 {
    let bounds = Aabb::around(triangles.as_flattened().iter().copied());
    (0..3)
        .map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]))
        .fold(0.0, f64::max)
}

fn vector(point: [f32; 3]) -> Vector3<f64> {
    point.map(f64::from).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_surfaces;

    #[test]
    fn a_cube_winds_once_around_what_is_inside() {
        let (_, cube) = closed_surfaces().into_iter().find(|(name, _)| *name == "cube").unwrap();
        let corner = |index: &u32| cube.positions[*index as usize].to_array().map(|x| x as f32);
        let triangles: Vec<Corners> = cube.triangles.iter().map(|t| t.each_ref().map(corner)).collect();
        for (point, winding, distance) in [
            ([0.0, 0.0, 0.0], 1.0, 0.5),
            ([0.25, -0.4, 0.125], 1.0, 0.1),
            ([0.75, 0.0, 0.1], 0.0, 0.25),
            ([0.8, 0.9, 0.0], 0.0, 0.5),
        ] {
            assert!((winding_number(&triangles, point) - winding).abs() < 1e-12, "{point:?}");
            assert!((distance_to(&triangles, point) - distance).abs() < 1e-7, "{point:?}");
        }
        assert_eq!(size(&triangles), 1.0);
    }
}
