//! Verification: the runtime's hits against brute force over posed triangles, and its vertices against the source.

mod oracle;
mod rays;
mod source_pose;

pub use oracle::Oracle;
pub use rays::{RayKind, Rays};
pub use source_pose::SourcePose;

use crate::{
    Progress,
    import::{Animation, ImportError},
    motion::turned,
};
use rayon::prelude::*;
use restpose_formats::{
    ModelView,
    rows::{CacheRow, NONE, SampleRow},
};
use restpose_runtime::{Affine, Asset, InstanceId, Ray, Scene};
use serde::Serialize;
use std::sync::Arc;

/// What to verify.
#[derive(Clone, Debug)]
pub struct VerifySettings {
    /// Rays over all poses. Default 100,000.
    pub rays: u64,
    /// Poses. Bones and morph weights stand at the file's samples, spread evenly; vertex caches at random times, every
    /// fourth time at a key. Default 16; no more are used than there are rays, nor, without vertex caches, samples.
    pub poses: u64,
    /// Seed of rays and instance transforms. Default 1.
    pub seed: u64,
}

impl Default for VerifySettings {
    fn default() -> Self {
        Self {
            rays: 100_000,
            poses: 16,
            seed: 1,
        }
    }
}

/// What was found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct VerifyReport {
    /// Rays traced, each by `closest_hit`, `any_hit`, and by brute force.
    pub rays: u64,
    /// Poses.
    pub poses: u64,
    /// Poses that the file was baked for.
    pub samples: u64,
    /// Rays that hit something, by brute force.
    pub hits: u64,
    /// Rays that hit by brute force and miss by the runtime, closest or any.
    pub missed: u64,
    /// Rays whose hit differs in any bit, or that hit only by the runtime.
    pub wrong: u64,
    /// Greatest distance between a vertex as posed and the source evaluated in `f64`, relative to the model's size.
    pub max_vertex_error: f64,
    /// Triangles tested by brute force.
    pub oracle_tests: u64,
    /// The first few rays that went wrong, to reproduce them.
    pub failures: Vec<Failure>,
}

/// A ray whose hit is not the oracle's.
#[derive(Clone, Debug, Serialize)]
pub struct Failure {
    /// Row of the sample section.
    pub sample: usize,
    /// Frames of the vertex caches.
    pub cache_frames: Vec<f64>,
    /// Ray origin.
    pub origin: [f32; 3],
    /// Ray direction.
    pub direction: [f32; 3],
    /// `t` and triangle by brute force.
    pub expected: Option<(f32, u32)>,
    /// `t` and triangle by the runtime.
    pub found: Option<(f32, u32)>,
}

/// Why nothing was verified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The source is not the one that the file was baked from.
    #[error(
        "{source_name} is not what this file was baked from: its content hash differs; bake it again, or give the original source"
    )]
    OtherSource {
        /// Name of the source given.
        source_name: String,
    },
    /// The source could not be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
}

/// Failures that a report lists.
const LISTED_FAILURES: usize = 8;

/// Compares, bit for bit, `closest_hit` and `any_hit` with brute force over all triangles, in poses from the file's
/// samples, every second one under a random instance transform; and every vertex with the source in `f64`.
///
/// # Errors
/// [`VerifyError::OtherSource`]. Wrong hits are results, not errors.
pub fn verify(
    asset: &Arc<Asset>,
    source: &Animation,
    settings: &VerifySettings,
    progress: &dyn Progress,
) -> Result<VerifyReport, VerifyError> {
    let model = asset.model();
    if model.hashes.source != source.source_hash {
        return Err(VerifyError::OtherSource {
            source_name: source.source_name.clone(),
        });
    }
    let samples = model.samples.len() as u64;
    let most_poses = if model.caches.is_empty() { samples } else { u64::MAX };
    let poses = settings.poses.min(most_poses).min(settings.rays).max(1);
    let mut report = VerifyReport {
        poses,
        samples,
        ..VerifyReport::default()
    };
    let mut random = fastrand::Rng::with_seed(settings.seed);
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    let clips = source_pose::source_clips(source, model);
    let turned_parts: Vec<usize> = (0..source.parts.len().min(model.parts.len()))
        .filter(|part| model.parts[*part].cache != NONE && source.parts[*part].cache.is_none())
        .collect();
    let source = &*turned(source, &clips, &turned_parts);
    let mut source_pose = SourcePose::new(source, model);

    progress.stage("verify", settings.rays);
    for pose in 0..poses {
        let sample = (u128::from(pose) * u128::from(samples) / u128::from(poses)) as usize;
        let cache_frames = random_frames(model, pose, &mut random);
        // A file without samples still has the pose without any clip.
        let row = model.samples.get(sample).copied().unwrap_or(SampleRow {
            clip: NONE,
            seconds: 0.0,
        });
        let transform = if pose % 2 == 0 {
            Affine::IDENTITY
        } else {
            random_transform(&mut random)
        };
        let posed = if row.clip == NONE {
            scene.set_default_pose(instance)
        } else {
            scene.play(instance, row.clip as usize, row.seconds)
        };
        let played = scene.set_cache_frames(instance, &cache_frames);
        let placed = scene.set_transform(instance, Affine::IDENTITY);
        debug_assert!(posed.is_ok() && played.is_ok() && placed.is_ok());
        let error = source_pose.greatest_error(&scene.commit(), instance, row, &cache_frames);
        report.max_vertex_error = report.max_vertex_error.max(error);

        let placed = scene.set_transform(instance, transform);
        debug_assert!(placed.is_ok());
        let rays = settings.rays * (pose + 1) / poses - settings.rays * pose / poses;
        let stand = (sample, cache_frames.as_slice());
        verify_pose(&mut scene, instance, stand, rays, &mut random, &mut report, progress);
    }
    Ok(report)
}

fn verify_pose(
    scene: &mut Scene,
    instance: InstanceId,
    (sample, cache_frames): (usize, &[f64]),
    ray_count: u64,
    random: &mut fastrand::Rng,
    report: &mut VerifyReport,
    progress: &dyn Progress,
) {
    let frame = scene.commit();
    let oracle = Oracle::new(&frame, &[instance]);
    let rays: Vec<Ray> = Rays::new(&oracle, random.u64(..)).take(ray_count as usize).collect();
    let outcomes: Vec<(Option<_>, Option<_>, bool)> = rays
        .par_iter()
        .map(|ray| {
            progress.advance(1);
            (oracle.closest_hit(ray), frame.closest_hit(ray), frame.any_hit(ray))
        })
        .collect();
    for (ray, (expected, found, any)) in rays.iter().zip(outcomes) {
        report.rays += 1;
        report.hits += u64::from(expected.is_some());
        let missed = expected.is_some() && (found.is_none() || !any);
        let wrong = !missed && (expected != found || any != expected.is_some());
        report.missed += u64::from(missed);
        report.wrong += u64::from(wrong);
        if (missed || wrong) && report.failures.len() < LISTED_FAILURES {
            let brief = |hit: Option<restpose_runtime::Hit>| hit.map(|hit| (hit.t, hit.triangle));
            let (origin, direction) = (ray.origin, ray.direction);
            report.failures.push(Failure {
                sample,
                cache_frames: cache_frames.to_vec(),
                origin,
                direction,
                expected: brief(expected),
                found: brief(found),
            });
        }
    }
    report.oracle_tests += ray_count * oracle.triangle_count() as u64;
}

/// Where each vertex cache stands in a pose: at a key in every fourth, else anywhere between its first and last.
fn random_frames(model: &ModelView, pose: u64, random: &mut fastrand::Rng) -> Vec<f64> {
    let frame = |cache: &CacheRow| {
        let last = cache.key_count - 1;
        if pose.is_multiple_of(4) {
            f64::from(random.u32(0..=last))
        } else {
            random.f64() * f64::from(last)
        }
    };
    model.caches.iter().map(frame).collect()
}

/// A rotation, mirrored at times, with uneven scale and a translation of a few units.
fn random_transform(random: &mut fastrand::Rng) -> Affine {
    let mut signed = |magnitude: f64| (random.f64() * 2.0 - 1.0) * magnitude;
    let axis = glam::DVec3::new(signed(1.0), signed(1.0), signed(1.0))
        .try_normalize()
        .unwrap_or(glam::DVec3::X);
    let rotation = glam::DQuat::from_axis_angle(axis, signed(3.1));
    let translation = glam::DVec3::new(signed(8.0), signed(8.0), signed(8.0));
    let scale = glam::DVec3::new(
        1.0 + signed(0.6),
        1.0 + signed(0.6),
        (1.0 + signed(0.6)) * signed(1.0).signum(),
    );
    let map = glam::DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    Affine {
        columns: map.to_cols_array_2d().map(|column| column.map(|x| x as f32)),
    }
}
