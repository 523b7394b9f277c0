use super::scenes::Triangle;
use crate::{MeasureError, clock::pose, posed_rays::corners};
use restpose_bake::{BakeSettings, NoProgress, bake, import::Animation};
use restpose_formats::{Bounds, write};
use restpose_runtime::{Asset, Scene};
use std::sync::Arc;

/// The triangles of a source, posed by the runtime as in up to `most` sampled poses of its first clip; one frame where
/// there is no clip.
pub(super) fn sampled_frames(animation: &Animation, most: usize) -> Result<Vec<Vec<Triangle>>, MeasureError> {
    // Boxes are not asked for: the cheapest do.
    let settings = BakeSettings {
        bounds: Bounds::Sampled,
        ..BakeSettings::default()
    };
    let baked = bake(animation, &settings, &NoProgress)?;
    let asset = Arc::new(Asset::from_bytes(&write(&baked.model)?)?);
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    let posed = |scene: &mut Scene| -> Vec<Triangle> {
        let points = corners(&scene.commit(), instance, &asset);
        let corners = points.chunks_exact(3);
        corners.map(|points| [points[0], points[1], points[2]]).collect()
    };
    let first_clip = asset.model().samples.iter().filter(|sample| sample.clip == 0);
    let mut frames = Vec::new();
    for sample in first_clip.take(most) {
        pose(&mut scene, instance, sample)?;
        frames.push(posed(&mut scene));
    }
    if frames.is_empty() {
        frames.push(posed(&mut scene));
    }
    Ok(frames)
}
