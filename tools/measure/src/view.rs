use crate::{MeasureError, clock::pose};
use restpose_formats::rows::SampleRow;
use restpose_runtime::{Aabb, Asset, Ray, Scene};
use std::sync::Arc;

/// Half the picture's width over its distance from the eye: a field of view of about 44°.
const HALF_WIDTH: f64 = 0.4;

/// Towards the eye: from the front (glTF's +z), a little from the right and from above.
const TOWARDS_EYE: [f64; 3] = [0.5, 0.35, 1.0];

/// A camera that sees a whole box, from a fixed direction.
pub(crate) struct View {
    eye: [f64; 3],
    /// Right and up as long as half the picture; to the picture's middle, with a part of length one along the view.
    axes: [[f64; 3]; 3],
}

impl View {
    /// The view of an asset in all of these poses.
    pub(crate) fn of_poses(asset: &Arc<Asset>, poses: &[SampleRow]) -> Result<Self, MeasureError> {
        let corners = || asset.model().triangles.iter().flat_map(|row| row.corners);
        let mut scene = Scene::new();
        let instance = scene.add(asset);
        let mut bounds = Aabb::EMPTY;
        for sample in poses {
            pose(&mut scene, instance, sample)?;
            let frame = scene.commit();
            bounds = bounds.union(Aabb::around(
                corners().filter_map(|vertex| frame.vertex(instance, vertex)),
            ));
        }
        Ok(Self::of(&bounds))
    }

    /// The view of the sphere around `bounds`, which fills the picture.
    pub(crate) fn of(bounds: &Aabb) -> Self {
        let (min, max) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
        let center: [f64; 3] = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
        let radius = 0.5 * (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt();
        // The sphere touches the pyramid that the picture's borders span: sin of the half angle is radius / distance.
        let distance = radius * (1.0 + HALF_WIDTH * HALF_WIDTH).sqrt() / HALF_WIDTH;
        let back = unit(TOWARDS_EYE);
        let right = unit([back[2], 0.0, -back[0]]);
        let up = cross(back, right);
        Self {
            eye: std::array::from_fn(|k| center[k] + distance * back[k]),
            axes: [
                right.map(|x| x * HALF_WIDTH),
                up.map(|x| x * HALF_WIDTH),
                back.map(|x| -x),
            ],
        }
    }

    /// The view of one pose, from the same direction: it touches two opposite borders of the picture.
    pub(crate) fn filled_by(points: &[[f32; 3]]) -> Self {
        let whole = Self::of(&Aabb::around(points.iter().copied()));
        let [right, up, forward] = whole.axes;
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            let from_eye = std::array::from_fn(|k| f64::from(point[k]) - whole.eye[k]);
            let depth = dot(forward, from_eye) * HALF_WIDTH * HALF_WIDTH;
            for (axis, own) in [right, up].into_iter().enumerate() {
                let at = dot(own, from_eye) / depth;
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at);
            }
        }
        let half = (0..2).map(|axis| 0.5 * (high[axis] - low[axis])).fold(0.0, f64::max);
        if !(half.is_finite() && half > 0.0) {
            return whole;
        }
        let center: [f64; 2] = std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
        Self {
            eye: whole.eye,
            axes: [
                right.map(|x| x * half),
                up.map(|x| x * half),
                std::array::from_fn(|k| forward[k] + center[0] * right[k] + center[1] * up[k]),
            ],
        }
    }

    /// The middle of the picture, `factor` times as large.
    pub(crate) fn magnified(self, factor: f64) -> Self {
        let [right, up, forward] = self.axes;
        Self {
            axes: [right.map(|x| x / factor), up.map(|x| x / factor), forward],
            ..self
        }
    }

    /// A ray through the middle of each pixel of a picture of `side` × `side`, rows from the top.
    pub(crate) fn rays(&self, side: u32) -> Vec<Ray> {
        (0..side)
            .flat_map(|row| (0..side).map(move |column| self.ray(side, row, column)))
            .collect()
    }

    /// The same rays in tiles of `tile` × `tile` pixels, tiles and pixels by rows from the top; `side` is a multiple.
    pub(crate) fn tiled_rays(&self, side: u32, tile: u32) -> Vec<Ray> {
        let tiles = side / tile;
        let pixels = (0..tiles * tiles).flat_map(|at| {
            let (row, column) = (at / tiles * tile, at % tiles * tile);
            (0..tile * tile).map(move |pixel| (row + pixel / tile, column + pixel % tile))
        });
        pixels.map(|(row, column)| self.ray(side, row, column)).collect()
    }

    fn ray(&self, side: u32, row: u32, column: u32) -> Ray {
        let [right, up, forward] = self.axes;
        let place = |pixel: u32| (2.0 * f64::from(pixel) + 1.0) / f64::from(side) - 1.0;
        let (x, y) = (place(column), -place(row));
        let direction: [f64; 3] = std::array::from_fn(|k| forward[k] + x * right[k] + y * up[k]);
        Ray::new(self.eye.map(|x| x as f32), direction.map(|x| x as f32))
    }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a point is in the picture: −1 to 1 from left to right and from bottom to top.
    fn seen_at(view: &View, point: [f64; 3]) -> [f64; 2] {
        let from_eye: [f64; 3] = std::array::from_fn(|k| point[k] - view.eye[k]);
        let dot = |axis: [f64; 3]| (0..3).map(|k| axis[k] * from_eye[k]).sum::<f64>();
        let [right, up, forward] = view.axes;
        let depth = dot(forward) * HALF_WIDTH * HALF_WIDTH;
        [dot(right) / depth, dot(up) / depth]
    }

    #[test]
    fn all_of_the_box_is_in_the_picture_and_fills_it() {
        for (min, max) in [([-1.0; 3], [1.0; 3]), ([10.0, -3.0, 0.5], [10.1, 4.0, 0.5])] {
            let view = View::of(&Aabb { min, max });
            let mut largest = 0.0f64;
            for corner in 0..8 {
                let point = std::array::from_fn(|k| f64::from(if corner >> k & 1 == 0 { min[k] } else { max[k] }));
                largest = seen_at(&view, point).iter().fold(largest, |far, x| far.max(x.abs()));
            }
            assert!((0.4..=1.0).contains(&largest), "{largest}");
        }
    }

    #[test]
    fn a_pose_touches_two_opposite_borders() {
        let points = [[3.0, 1.0, 0.0], [4.0, 1.5, 0.1], [3.5, 1.2, -0.4], [3.2, 1.1, 0.3]];
        let rays = View::filled_by(&points).rays(64);
        let whole = View::of(&Aabb::around(points));
        let seen = |ray: &Ray| {
            seen_at(
                &whole,
                std::array::from_fn(|k| f64::from(ray.origin[k] + ray.direction[k])),
            )
        };
        let places = points.map(|point| seen_at(&whole, point.map(f64::from)));
        let (first, last) = (seen(&rays[0]), seen(&rays[64 * 64 - 1]));
        // The outermost rays run half a pixel of 64 inside the border.
        let pixel = (last[0] - first[0]) / 63.0;
        let borders = [
            [first[0] - 0.5 * pixel, last[0] + 0.5 * pixel],
            [last[1] - 0.5 * pixel, first[1] + 0.5 * pixel],
        ];
        let mut touched = 0;
        for axis in 0..2 {
            let low = places.iter().fold(f64::INFINITY, |low, place| low.min(place[axis]));
            let high = places
                .iter()
                .fold(f64::NEG_INFINITY, |high, place| high.max(place[axis]));
            // f32 rays.
            assert!(low >= borders[axis][0] - 1e-4 && high <= borders[axis][1] + 1e-4);
            touched += usize::from(low - borders[axis][0] < 1e-4 && borders[axis][1] - high < 1e-4);
        }
        assert_eq!(touched, 1);
        assert_eq!(View::filled_by(&[[1.0; 3]]).rays(1).len(), 1, "a point");
    }

    #[test]
    fn tiles_hold_the_same_rays() {
        let view = View::of(&Aabb {
            min: [-1.0; 3],
            max: [1.0; 3],
        });
        let (rows, tiles) = (view.rays(6), view.tiled_rays(6, 2));
        assert_eq!(tiles.len(), 36);
        assert_eq!(tiles[..6], [rows[0], rows[1], rows[6], rows[7], rows[2], rows[3]]);
        assert_eq!(tiles[35], rows[35]);
        let near = view.magnified(3.0).rays(2);
        assert!((0..3).all(|k| near[0].origin[k] == rows[0].origin[k]));
        let across = |rays: &[Ray], a: usize, b: usize| rays[a].direction[0] - rays[b].direction[0];
        // Middles of pixels are half a picture apart in one, five sixths in the other.
        let ratio = across(&near, 0, 1) / across(&rows, 0, 5) * (5.0 / 3.0);
        assert!((ratio - 1.0 / 3.0).abs() < 1e-5, "{ratio}");
    }

    #[test]
    fn rays_run_through_their_pixels() {
        let view = View::of(&Aabb {
            min: [-1.0; 3],
            max: [1.0; 3],
        });
        let rays = view.rays(4);
        assert_eq!(rays.len(), 16);
        let through = |ray: &Ray| {
            seen_at(
                &view,
                std::array::from_fn(|k| f64::from(ray.origin[k] + ray.direction[k])),
            )
        };
        // f32 rays: a few roundings of 2⁻²⁴ at coordinates below ten.
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5;
        assert!(
            near(through(&rays[0]), [-0.75, 0.75]),
            "top left first: {:?}",
            through(&rays[0])
        );
        assert!(
            near(through(&rays[7]), [0.75, 0.25]),
            "rows one after the other: {:?}",
            through(&rays[7])
        );
    }
}
