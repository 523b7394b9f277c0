//! Verification: the runtime's hits against brute force over posed triangles, and its vertices against the source.

mod oracle;
mod pose_source;
mod poses;
mod random_map;
mod random_pose;
mod rays;
mod report;
mod source_curve;
mod source_nodes;
mod source_pose;
#[cfg(test)]
mod tests;

pub use oracle::Oracle;
pub use pose_source::{PoseFamily, PoseSource, SMALL_TURN_DEG};
pub use poses::{BonePose, DrawnPose, Poses};
pub use rays::{RayKind, Rays};
pub use report::{Failure, FamilyReport, VerifyReport};
pub use source_pose::SourcePose;

use crate::{
    Progress,
    import::{Animation, ImportError},
    motion::turned,
};
use rayon::prelude::*;
use restpose_formats::{Bounds, rows::NONE};
use restpose_runtime::{Affine, Asset, Posing, Ray, Scene};
use std::{borrow::Cow, sync::Arc};

/// What to verify.
#[derive(Clone, Debug)]
pub struct VerifySettings {
    /// Rays over all poses. Default 100,000.
    pub rays: u64,
    /// Poses. Default 16; no more are used than there are rays, nor, of samples without vertex caches, than there are.
    pub poses: u64,
    /// Where poses come from. Default: samples where the file's boxes are sampled, else clips. Other poses of a file with
    /// sampled boxes measure what sampling loses.
    pub pose_source: Option<PoseSource>,
    /// Seed of poses, rays and instance transforms. Default 1.
    pub seed: u64,
}

impl Default for VerifySettings {
    fn default() -> Self {
        Self {
            rays: 100_000,
            poses: 16,
            pose_source: None,
            seed: 1,
        }
    }
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

/// Compares, bit for bit, `closest_hit` and `any_hit` with brute force over all triangles, in poses of the source that the
/// settings name, every second one under a random instance transform; and every vertex with the source in `f64`.
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
    let pose_source = settings.pose_source.unwrap_or(match model.meta.bounds {
        Bounds::Sampled => PoseSource::Samples,
        Bounds::Envelope => PoseSource::Clips,
    });
    let samples = model.samples.len() as u64;
    let most_poses = match pose_source {
        PoseSource::Samples if model.caches.is_empty() => samples,
        _ => u64::MAX,
    };
    let count = settings.poses.min(most_poses).min(settings.rays).max(1);
    let source = &*as_baked(source, asset);
    let mut source_pose = SourcePose::new(source, model);
    let mut poses = Poses::new(source, model, pose_source, settings.seed, count);
    let families = match pose_source {
        PoseSource::Random => poses.families(),
        PoseSource::Samples | PoseSource::Clips => &[],
    };
    let mut report = VerifyReport {
        rays: 0,
        poses: count,
        pose_source,
        seed: settings.seed,
        bounds: model.meta.bounds,
        samples,
        hits: 0,
        missed: 0,
        wrong: 0,
        max_vertex_error: 0.0,
        oracle_tests: 0,
        families: families.iter().map(|family| FamilyReport::new(*family)).collect(),
        failures: Vec::new(),
    };
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    let forced = scene.set_posing(instance, Posing::Recomputed);
    debug_assert!(forced.is_ok());

    progress.stage("verify", settings.rays);
    for index in 0..count {
        let pose = poses.pose(index);
        let posed = pose.set(&mut scene, instance);
        let placed = scene.set_transform(instance, Affine::IDENTITY);
        debug_assert!(posed.is_ok() && placed.is_ok());
        let error = source_pose.greatest_error(&scene.commit(), instance, &pose.bones, &pose.cache_frames);
        report.max_vertex_error = report.max_vertex_error.max(error);

        let placed = scene.set_transform(instance, pose.transform);
        debug_assert!(placed.is_ok());
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &[instance]);
        let ray_count = part_of(settings.rays, index + 1, count) - part_of(settings.rays, index, count);
        let rays: Vec<Ray> = Rays::new(&oracle, pose.ray_seed).take(ray_count as usize).collect();
        let outcomes: Vec<(Option<_>, Option<_>, bool)> = rays
            .par_iter()
            .map(|ray| {
                progress.advance(1);
                (oracle.closest_hit(ray), frame.closest_hit(ray), frame.any_hit(ray))
            })
            .collect();
        let outcomes = rays.iter().zip(outcomes);
        // After the rays, which were to find nothing prepared.
        frame.prepare();
        report.add(
            &pose,
            &frame.stats(),
            outcomes.map(|(ray, (expected, found, any))| (ray, expected, found, any)),
        );
        report.oracle_tests += ray_count * oracle.triangle_count() as u64;
    }
    Ok(report)
}

/// `count / of` of `whole`, rounded down.
fn part_of(whole: u64, count: u64, of: u64) -> u64 {
    (u128::from(whole) * u128::from(count) / u128::from(of)) as u64
}

/// The source with vertex caches for the parts whose morph targets were baked as such.
fn as_baked<'a>(source: &'a Animation, asset: &Asset) -> Cow<'a, Animation> {
    let model = asset.model();
    let parts: Vec<usize> = (0..source.parts.len().min(model.parts.len()))
        .filter(|part| model.parts[*part].cache != NONE && source.parts[*part].cache.is_none())
        .collect();
    turned(source, &source_nodes::source_clips(source, model), &parts)
}
