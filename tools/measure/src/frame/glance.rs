#![expect(unsafe_code, reason = "maps a file that it has just written")]

use super::{
    ours::STRATEGIES,
    scene::{File, FrameScene},
    settings::FrameSettings,
};
use crate::{MeasureError, peak_memory::resident_bytes, statistics::median};
use restpose_runtime::{Affine, Asset, Pose, PoseEvaluator, Posing, Scene};
use serde::Serialize;
use std::{io::Write, sync::Arc, time::Instant};

/// Times that a file is opened; the median counts.
const OPENINGS: usize = 5;

/// Memory by which a scene must have grown before the growth says what an instance takes: what was freed before is used
/// up by then.
const GROWTH_BYTES: u64 = 64 << 20;

/// Instances that are added at most to find out.
const MOST_INSTANCES: usize = 1 << 15;

/// What a file costs, rays aside.
#[derive(Clone, Debug, Serialize)]
pub struct Glance {
    /// File name of the source.
    pub scene: String,
    /// The first strategy of the runtime that takes this file.
    pub strategy: &'static str,
    /// Of one instance, degenerate ones included.
    pub triangles: u64,
    /// Of one instance.
    pub vertices: u64,
    /// Maps of a palette.
    pub bones: u64,
    /// Length of the file.
    pub file_bytes: u64,
    /// Bake without import; 0 where it was baked before.
    pub bake_seconds: f64,
    /// Mapping and checking the file, its pages in memory: median, microseconds.
    pub open_us: f64,
    /// The same per 2³⁰ bytes.
    pub open_seconds_per_gib: f64,
    /// Palette, morph weights and frames of vertex caches of an instance.
    pub pose_bytes: u64,
    /// Memory that a further instance takes beside these, its pose given and committed, no ray yet; null where the system
    /// does not say.
    pub bytes_per_instance: Option<f64>,
}

/// A row per file, not per strategy: no ray has come yet.
pub(super) fn glances(scene: &FrameScene, settings: &FrameSettings) -> Result<Vec<Glance>, MeasureError> {
    let mut out = Vec::new();
    let mut known: Vec<Arc<File>> = Vec::new();
    for strategy in STRATEGIES.iter().filter(|strategy| settings.chosen(strategy.name)) {
        let Some(file) = scene.file(strategy.tree) else {
            continue;
        };
        if known.iter().any(|known| Arc::ptr_eq(known, &file)) {
            continue;
        }
        let model = file.asset.model();
        let pose_bytes = model.bones.len() * size_of::<Affine>()
            + model.morph_targets.len() * size_of::<f32>()
            + model.caches.len() * size_of::<f64>();
        let open_seconds = open_seconds(&file)?;
        out.push(Glance {
            scene: scene.name.clone(),
            strategy: strategy.name,
            triangles: model.triangles.len() as u64,
            vertices: model.vertices.len() as u64 - 1,
            bones: model.bones.len() as u64,
            file_bytes: file.bytes.len() as u64,
            bake_seconds: file.bake_seconds,
            open_us: 1e6 * open_seconds,
            open_seconds_per_gib: open_seconds / file.bytes.len() as f64 * (1u64 << 30) as f64,
            pose_bytes: pose_bytes as u64,
            bytes_per_instance: bytes_per_instance(&file.asset, strategy.posing)?
                .map(|bytes| bytes - pose_bytes as f64),
        });
        known.push(file);
    }
    Ok(out)
}

fn open_seconds(file: &File) -> Result<f64, MeasureError> {
    let fault = |error: &dyn std::fmt::Display| MeasureError::Reopen {
        fault: error.to_string(),
    };
    let mut copy = tempfile::NamedTempFile::new().map_err(|error| fault(&error))?;
    copy.write_all(&file.bytes).map_err(|error| fault(&error))?;
    let mut times = Vec::with_capacity(OPENINGS);
    for _ in 0..OPENINGS {
        let start = Instant::now();
        // SAFETY: the file is ours, written whole, and stays as it is until all assets are gone.
        let asset = unsafe { Asset::map(copy.path()) };
        times.push(start.elapsed().as_secs_f64());
        asset.map_err(|error| fault(&error))?;
    }
    Ok(median(&mut times))
}

/// Memory of an instance whose pose is given, pose included: the slope between half of the instances and all, of as many as it
/// takes to see it.
fn bytes_per_instance(asset: &Arc<Asset>, posing: Posing) -> Result<Option<f64>, MeasureError> {
    let Some(before) = resident_bytes() else {
        return Ok(None);
    };
    let (mut pose, model) = (Pose::default(), asset.model());
    let clip = (!model.clips.is_empty()).then_some(0);
    PoseEvaluator::default().evaluate(model, clip, 0.0, &mut pose);
    let mut scene = Scene::new();
    let (mut count, mut half) = (0usize, (0usize, before));
    while let Some(now) = resident_bytes() {
        if now.saturating_sub(before) >= GROWTH_BYTES || count >= MOST_INSTANCES {
            return Ok(Some((now as f64 - half.1 as f64) / (count - half.0).max(1) as f64));
        }
        half = (count, now);
        for _ in 0..count.max(16) {
            let instance = scene.add(asset);
            scene.set_posing(instance, posing)?;
            scene.set_palette(instance, &pose.palette, &pose.morph_weights)?;
            count += 1;
        }
        scene.commit();
    }
    Ok(None)
}
