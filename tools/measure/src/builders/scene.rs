use super::scenes::{Generated, Triangle};
use crate::{MeasureError, clock::pose, posed_rays::corners};
use restpose_bake::{BakeSettings, MotionClass, NoProgress, bake, import::Animation};
use restpose_formats::{Bounds, write};
use restpose_runtime::{Asset, Scene};
use std::sync::Arc;

/// Triangles to build trees over.
#[derive(Clone, Debug)]
pub struct BuilderScene {
    pub(super) name: String,
    pub(super) triangles: Vec<Triangle>,
    /// The same triangles in other poses, in order of time; empty where nothing moves.
    pub(super) frames: Vec<Vec<Triangle>>,
}

impl BuilderScene {
    /// A scene that is made.
    #[must_use]
    pub fn generated(scene: Generated, seed: u64) -> Self {
        Self {
            name: scene.to_string(),
            triangles: scene.triangles(seed),
            frames: Vec::new(),
        }
    }

    /// A source as it stands at the start of its first clip, or without any, and up to `frames` sampled poses of that clip.
    ///
    /// # Errors
    /// [`MeasureError`]: the source does not bake, or has no triangles.
    pub fn imported(animation: &Animation, frames: usize) -> Result<Self, MeasureError> {
        // No clusters: only posed triangles are asked for, and those as they are in the source.
        let caches = animation.parts.iter().filter(|part| part.cache.is_some());
        let settings = BakeSettings {
            bounds: Bounds::Sampled,
            position_error: Some(0.0),
            class_overrides: caches.map(|part| (part.name.clone(), MotionClass::Free)).collect(),
            ..BakeSettings::default()
        };
        let baked = bake(animation, &settings, &NoProgress)?;
        let asset = Arc::new(Asset::from_bytes(&write(&baked.model)?)?);
        let samples = &asset.model().samples;
        let first_clip: Vec<_> = samples.iter().filter(|sample| sample.clip == 0).collect();
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        let posed = |scene: &mut Scene| -> Vec<Triangle> {
            let points = corners(&scene.commit(), instance, &asset);
            points
                .chunks_exact(3)
                .map(|points| [points[0], points[1], points[2]])
                .collect()
        };
        let mut poses = Vec::new();
        for sample in first_clip.into_iter().take(frames.max(1)) {
            pose(&mut scene, instance, sample)?;
            poses.push(posed(&mut scene));
        }
        let triangles = match poses.first() {
            Some(first) => first.clone(),
            None => posed(&mut scene),
        };
        if poses.len() < 2 || frames == 0 {
            poses.clear();
        }
        Ok(Self {
            name: animation.source_name.clone(),
            triangles,
            frames: poses,
        })
    }

    /// What the tables call it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}
