//! `goose.obj` and `goose.pc2`: a goose of jelly heads a ball. The files say where each point is in each frame and
//! nothing else; what moved them is here.

use crate::ball_flight::{Bounce, flight};
use crate::goose_body::{Goose, HEAD, goose};
use crate::goose_pose::{BoneMap, HEADER, LANDING, pose};
use crate::jelly::Knock;
use crate::obj_writer::{FaceGroup, obj_bytes};
use crate::point_cache_writer::{CacheWriteError, pc2_bytes};
use crate::polygons::{Polygons, honeycomb_ball, polygon_loft};
use crate::rotation::sin_turn;
use crate::solids::circle;
use glam::DVec3;

const FRAMES: u32 = 84;
const FRAMES_PER_SECOND: f64 = 24.0;
const BALL_RADIUS: f64 = 0.16;

/// The bytes of the OBJ file and of the PC2 file.
///
/// # Errors
/// [`CacheWriteError`] as [`pc2_bytes`] says.
pub fn goose_obj_and_pc2() -> Result<(Vec<u8>, Vec<u8>), CacheWriteError> {
    let (goose, ball, stage) = (goose(), honeycomb_ball(1), stage());
    let bounces = bounces(&goose);
    let frames: Vec<Vec<[f32; 3]>> = (0..FRAMES)
        .map(|frame| {
            let time = f64::from(frame);
            let (centre, turn) = flight(&bounces, time / FRAMES_PER_SECOND);
            let ball = ball.positions.iter().map(|point| centre + turn * *point * BALL_RADIUS);
            let points = posed(&goose, time).into_iter().chain(ball);
            points
                .chain(stage.positions.iter().copied())
                .map(|point| point.as_vec3().to_array())
                .collect()
        })
        .collect();
    let mut first = 0;
    let groups = [("goose", &goose.mesh), ("ball", &ball), ("stage", &stage)].map(|(name, mesh)| {
        let shifted = |face: &Vec<u32>| face.iter().map(|corner| corner + first).collect();
        let group = FaceGroup {
            name: name.to_owned(),
            faces: mesh.faces.iter().map(shifted).collect(),
        };
        first += mesh.positions.len() as u32;
        group
    });
    let obj = obj_bytes(frames.first().map_or(&[], Vec::as_slice), &groups);
    Ok((obj, pc2_bytes(&frames, 0.0, 1.0)?))
}

/// A round step on a round slab.
fn stage() -> Polygons {
    let profile = [(1.2, -0.16), (1.2, -0.07), (1.14, -0.05), (1.1, 0.0)];
    polygon_loft(&profile.map(|(radius, y)| circle(radius, y, 32)))
}

/// The ball comes from the goose's right, bounces before it, is headed, and leaves to its left.
fn bounces(goose: &Goose) -> Vec<Bounce> {
    let maps = pose(&goose.bones, HEADER);
    let brow = maps[HEAD].place(goose.bones[HEAD].joint + DVec3::new(0.0, 0.15, 0.1));
    let up_and_ahead = DVec3::new(0.0, 0.8, 0.6);
    let bounce = |frame: f64, centre: DVec3, axis: DVec3, spin_deg| Bounce {
        seconds: frame / FRAMES_PER_SECOND,
        centre,
        axis,
        spin_deg,
    };
    let on_stage = |x, z| DVec3::new(x, BALL_RADIUS, z);
    vec![
        bounce(0.0, DVec3::new(-1.2, 1.25, 0.9), DVec3::new(0.6, 0.0, -0.8), 220.0),
        bounce(13.0, on_stage(-0.6, 0.8), DVec3::new(0.0, 0.6, -0.8), 410.0),
        bounce(
            HEADER,
            brow + up_and_ahead * BALL_RADIUS,
            DVec3::new(0.48, 0.6, -0.64),
            1_150.0,
        ),
        bounce(58.0, on_stage(0.58, 0.8), DVec3::new(0.0, 0.0, -1.0), 640.0),
        bounce(74.0, on_stage(0.84, 0.6), DVec3::new(0.28, 0.0, -0.96), 300.0),
        bounce(86.0, on_stage(1.0, 0.4), DVec3::Z, 0.0),
    ]
}

/// The goose's points. Time in frames.
fn posed(goose: &Goose, time: f64) -> Vec<DVec3> {
    let maps = pose(&goose.bones, time);
    let seconds = time / FRAMES_PER_SECOND;
    let knock = |frame: f64, place: [f64; 3], height| Knock {
        seconds: frame / FRAMES_PER_SECOND,
        place: DVec3::from(place),
        height,
    };
    let knocks = [
        knock(HEADER, [0.0, 1.4, 0.4], 0.05),
        knock(LANDING, [0.0, 0.1, 0.0], 0.075),
    ];
    let points = goose.mesh.positions.iter().zip(&goose.weights).zip(&goose.outward);
    points
        .map(|((rest, weights), outward)| {
            let bulge: f64 = knocks.iter().map(|knock| knock.bulge(*rest, seconds)).sum();
            // Feet are firm, and only the trunk breathes.
            let soft = ((rest.y - 0.12) / 0.3).clamp(0.0, 1.0);
            let breath = 0.012 * sin_turn(0.8 * seconds - 0.5 * rest.z);
            let swollen = *rest + *outward * (soft * (bulge + breath));
            blended(&maps, weights, swollen) + DVec3::X * (soft * wobble(*rest, seconds))
        })
        .collect()
}

/// The mean of the bones' images of a point.
fn blended(maps: &[BoneMap], weights: &[(usize, f64)], point: DVec3) -> DVec3 {
    let images = weights.iter().map(|&(bone, weight)| maps[bone].place(point) * weight);
    images.sum()
}

/// Sideways sway that climbs through the body.
fn wobble(rest: DVec3, seconds: f64) -> f64 {
    0.022 * (rest.y - 0.1) * sin_turn(1.4 * seconds - 0.8 * rest.y + 0.3 * rest.z)
}
