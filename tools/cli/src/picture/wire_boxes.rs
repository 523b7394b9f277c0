use super::{
    camera::{Camera, corners},
    canvas::Canvas,
    colour::Colour,
    line,
};
use restpose_formats::geom::Aabb;

/// Corner pairs of a box's twelve edges, as [`corners`] numbers them: those that differ in one bit.
const EDGES: [(usize, usize); 12] = [
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
];

/// Edges are cut at this share of the farthest corner's depth before the camera.
const NEAR_SHARE: f64 = 1e-3;

/// Draws the edges of a box.
pub fn draw(canvas: &mut Canvas, camera: &Camera, bounds: &Aabb, thickness: f64, colour: Colour) {
    if bounds.is_empty() {
        return;
    }
    let corners = corners(bounds);
    let near = corners
        .iter()
        .map(|corner| camera.depth_of(*corner))
        .fold(0.0, f64::max)
        * NEAR_SHARE;
    for (from, to) in EDGES.map(|(from, to)| (corners[from], corners[to])) {
        let (from_depth, to_depth) = (camera.depth_of(from), camera.depth_of(to));
        let cut = |inside, inside_depth: f64, outside, outside_depth: f64| {
            let share: f64 = (inside_depth - near) / (inside_depth - outside_depth);
            let (inside, outside): (glam::DVec3, glam::DVec3) = (inside, outside);
            inside.lerp(outside, share)
        };
        let (from, to) = match (from_depth > near, to_depth > near) {
            (true, true) => (from, to),
            (true, false) => (from, cut(from, from_depth, to, to_depth)),
            (false, true) => (cut(to, to_depth, from, from_depth), to),
            (false, false) => continue,
        };
        if let (Some(from), Some(to)) = (camera.project(from), camera.project(to)) {
            line::draw(canvas, from, to, thickness, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::camera::Lens;
    use glam::DVec3;

    const LENS: Lens = Lens {
        fov_deg: 60.0,
        width: 64,
        height: 64,
    };

    fn painted(camera: &Camera, bounds: &Aabb) -> usize {
        let mut canvas = Canvas::filled(64, 64, Colour::ZERO);
        draw(&mut canvas, camera, bounds, 1.5, Colour::ONE);
        canvas.to_rgb().iter().filter(|byte| **byte > 0).count() / 3
    }

    #[test]
    fn a_box_in_view_is_drawn_and_one_behind_is_not() {
        let camera = Camera::looking_at(DVec3::Z * 5.0, DVec3::ZERO, LENS);
        let unit = Aabb {
            min: [-1.0; 3],
            max: [1.0; 3],
        };
        assert!(painted(&camera, &unit) > 100);
        let behind = Aabb {
            min: [-1.0, -1.0, 7.0],
            max: [1.0, 1.0, 9.0],
        };
        assert_eq!(painted(&camera, &behind), 0);
        assert_eq!(painted(&camera, &Aabb::EMPTY), 0);
    }

    #[test]
    fn a_box_around_the_camera_is_cut_not_lost() {
        let camera = Camera::looking_at(DVec3::ZERO, DVec3::NEG_Z, LENS);
        let around = Aabb {
            min: [-1.0, -1.0, -4.0],
            max: [1.0, 1.0, 4.0],
        };
        assert!(painted(&camera, &around) > 50);
    }
}
