use crate::{AimedRays, Landmarks};
use restpose_bake::verify::{Oracle, Rays};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, Posing, Ray, Scene};
use std::sync::Arc;

/// A scene and what it was made of, to be compared with brute force.
#[derive(Default)]
pub struct Stage {
    /// The scene. Instances are added by [`Stage::add`].
    pub scene: Scene,
    actors: Vec<(InstanceId, Arc<Asset>, Affine)>,
}

impl Stage {
    /// A stage with one instance, in a sampled pose of its asset.
    #[must_use]
    pub fn with(asset: &Arc<Asset>, transform: Affine, sample: usize) -> Self {
        let mut stage = Self::default();
        stage.add(asset, transform, sample);
        stage
    }

    /// Adds an instance in a sampled pose of its asset; samples beyond the last count from the first again.
    ///
    /// # Panics
    /// When the transform is not finite.
    pub fn add(&mut self, asset: &Arc<Asset>, transform: Affine, sample: usize) -> InstanceId {
        let instance = self.scene.add(asset);
        self.scene.set_posing(instance, Posing::Recomputed).unwrap();
        self.scene.set_transform(instance, transform).unwrap();
        self.actors.push((instance, Arc::clone(asset), transform));
        let samples = asset.model().samples;
        let sample = samples[sample % samples.len()];
        if sample.clip != restpose_formats::rows::NONE {
            self.scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        }
        instance
    }

    /// The frame as it stands, its brute force and its landmarks.
    pub fn commit(&mut self) -> (Frame<'_>, Oracle, Landmarks) {
        let palettes: Vec<Vec<Affine>> = self
            .actors
            .iter()
            .map(|(instance, ..)| {
                self.scene
                    .pose(*instance)
                    .map_or_else(|_| Vec::new(), |pose| pose.palette)
            })
            .collect();
        let frame = self.scene.commit();
        let instances: Vec<InstanceId> = self.actors.iter().map(|(instance, ..)| *instance).collect();
        let oracle = Oracle::new(&frame, &instances);
        let mut marks = Landmarks::default();
        for ((instance, asset, transform), palette) in self.actors.iter().zip(&palettes) {
            marks.add(&frame, *instance, asset, palette, *transform);
        }
        (frame, oracle, marks)
    }

    /// Compares so many ordinary rays and so many aimed ones with brute force; the number of hits.
    ///
    /// # Panics
    /// Where they differ by a bit.
    pub fn assert_equals_brute_force(&mut self, name: &str, rays: usize, seed: u64) -> usize {
        let (frame, oracle, marks) = self.commit();
        let ordinary = Rays::new(&oracle, seed).take(rays);
        let mut hits = assert_rays_equal(name, &frame, &oracle, ordinary);
        if !marks.triangles.is_empty() {
            hits += assert_rays_equal(name, &frame, &oracle, AimedRays::new(&marks, seed).take(rays));
        }
        hits
    }
}

/// A hit as bits, so that zeros of both signs differ.
#[must_use]
pub fn hit_bits(hit: Option<Hit>) -> Option<(InstanceId, u32, [u32; 3])> {
    hit.map(|hit| (hit.instance, hit.triangle, [hit.t, hit.u, hit.v].map(f32::to_bits)))
}

/// Compares rays with brute force; the number of hits.
///
/// # Panics
/// Where they differ by a bit.
pub fn assert_rays_equal(name: &str, frame: &Frame, oracle: &Oracle, rays: impl IntoIterator<Item = Ray>) -> usize {
    let mut hits = 0;
    for ray in rays {
        let expected = oracle.closest_hit(&ray);
        let found = frame.closest_hit(&ray);
        assert_eq!(hit_bits(found), hit_bits(expected), "{name}: {ray:?}");
        assert_eq!(frame.any_hit(&ray), expected.is_some(), "{name}: {ray:?}");
        hits += usize::from(expected.is_some());
    }
    hits
}
