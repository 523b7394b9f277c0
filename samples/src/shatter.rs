//! `shatter.obj` and `shatter.pc2`: a ball bursts a vase into two thousand shards that tumble each in its own way. No few
//! maps explain such a motion.

use crate::ball_flight::{Bounce, flight};
use crate::obj_writer::{FaceGroup, obj_bytes};
use crate::point_cache_writer::{CacheWriteError, pc2_bytes};
use crate::polygons::{Polygons, honeycomb_ball, polygon_loft};
use crate::shard_flight::{Throw, thrown};
use crate::solids::circle;
use crate::vase::{Shard, shards};
use fastrand::Rng;
use glam::DVec3;

const FRAMES: u32 = 10;
/// Readers take a PC2 file's frame for a 24th of a second; a sample comes with every second one.
const SAMPLE_RATE: f32 = 2.0;
const SAMPLES_PER_SECOND: f64 = 12.0;

/// Where the ball hits, on the belly to the left.
const IMPACT: DVec3 = DVec3::new(-0.4, 0.6, 0.0);
const BALL_RADIUS: f64 = 0.11;
/// Speed at which cracks run from there, scene units per second.
const CRACK_SPEED: f64 = 5.0;

/// The mesh, and where its points are in each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Shatter {
    /// `[frame][point]`, scene units.
    pub frames: Vec<Vec<[f32; 3]>>,
    /// `vase`, the shards one after the other; `ball`; `slab`.
    pub groups: Vec<FaceGroup>,
}

/// The bytes of the OBJ file and of the PC2 file.
///
/// # Errors
/// [`CacheWriteError`] as [`pc2_bytes`] says.
pub fn shatter_obj_and_pc2() -> Result<(Vec<u8>, Vec<u8>), CacheWriteError> {
    let Shatter { frames, groups } = shatter();
    let obj = obj_bytes(frames.first().map_or(&[], Vec::as_slice), &groups);
    Ok((obj, pc2_bytes(&frames, 0.0, SAMPLE_RATE)?))
}

/// The whole animation; in its first frame the vase is whole.
pub fn shatter() -> Shatter {
    let mut rng = Rng::with_seed(2_016);
    let shards: Vec<(Shard, Throw)> = shards()
        .into_iter()
        .map(|shard| (shard, throw(&shard, &mut rng)))
        .collect();
    let (ball, slab) = (honeycomb_ball(1), slab());
    let bounces = bounces();
    let frames = (0..FRAMES).map(|frame| {
        let seconds = f64::from(frame) / SAMPLES_PER_SECOND;
        let (centre, turn) = flight(&bounces, seconds);
        let shards = shards.iter().flat_map(|(shard, throw)| thrown(shard, throw, seconds));
        let ball = ball.positions.iter().map(|point| centre + turn * *point * BALL_RADIUS);
        let points = shards.chain(ball).chain(slab.positions.iter().copied());
        points.map(|point| point.as_vec3().to_array()).collect()
    });
    let mut groups = vec![FaceGroup {
        name: "vase".to_owned(),
        faces: Vec::new(),
    }];
    let mut first = 0;
    let mut shifted = |faces: &[Vec<u32>], points: usize| -> Vec<Vec<u32>> {
        let own = first;
        first += points as u32;
        let shift = |face: &Vec<u32>| face.iter().map(|corner| corner + own).collect();
        faces.iter().map(shift).collect()
    };
    for (shard, _) in &shards {
        groups[0].faces.extend(shifted(&shard.faces(), shard.corners.len()));
    }
    for (name, mesh) in [("ball", &ball), ("slab", &slab)] {
        groups.push(FaceGroup {
            name: name.to_owned(),
            faces: shifted(&mesh.faces, mesh.positions.len()),
        });
    }
    Shatter {
        frames: frames.collect(),
        groups,
    }
}

/// A round slab whose top is the ground.
fn slab() -> Polygons {
    let profile = [(1.28, -0.08), (1.28, -0.02), (1.25, 0.0)];
    polygon_loft(&profile.map(|(radius, y)| circle(radius, y, 36)))
}

/// The ball comes from the left, goes through the vase and bounces on.
fn bounces() -> [Bounce; 3] {
    let bounce = |seconds, centre: [f64; 3], axis: DVec3, spin_deg| Bounce {
        seconds,
        centre: centre.into(),
        axis,
        spin_deg,
    };
    [
        bounce(0.0, [IMPACT.x - BALL_RADIUS, IMPACT.y, 0.0], DVec3::NEG_Z, 300.0),
        bounce(0.4, [0.5, BALL_RADIUS, 0.15], DVec3::NEG_Z, 420.0),
        bounce(0.8, [0.95, BALL_RADIUS, 0.3], DVec3::NEG_Z, 0.0),
    ]
}

/// Away from the axis and from the impact, and each shard as it will.
fn throw(shard: &Shard, rng: &mut Rng) -> Throw {
    let middle = shard.middle();
    let distance = middle.distance(IMPACT);
    let burst = (middle - DVec3::new(-0.1, 0.45, 0.0)).normalize_or(DVec3::Y);
    let pushed = DVec3::X * (0.3 / (0.5 + distance));
    let own = in_ball(rng);
    Throw {
        seconds: distance / CRACK_SPEED,
        velocity: burst * (0.3 + 0.6 * rng.f64())
            + pushed * rng.f64()
            + own * DVec3::new(0.65, 1.1, 0.65)
            + DVec3::Y * 0.6,
        axis: in_ball(rng).normalize_or(DVec3::Y),
        spin_deg: 120.0 + 360.0 * rng.f64(),
    }
}

/// A random point of the unit ball.
fn in_ball(rng: &mut Rng) -> DVec3 {
    loop {
        let point = DVec3::from([(); 3].map(|()| 2.0 * rng.f64() - 1.0));
        if point.length_squared() <= 1.0 {
            return point;
        }
    }
}
