use crate::{AimedRays, Landmarks, following_twin, kd_twin};
use restpose_bake::verify::{Oracle, Rays};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, Posing, Ray, Scene};
use std::sync::Arc;

/// A scene and what it was made of, to be compared with brute force.
#[derive(Default)]
pub struct Stage {
    /// The scene. Instances are added by [`Stage::add`].
    pub scene: Scene,
    actors: Vec<(InstanceId, Arc<Asset>, Affine)>,
    twins: Vec<Twins>,
}

/// The same instances with other trees, with which every comparison is made, too.
struct Twins {
    name: &'static str,
    make: fn(&Asset) -> Arc<Asset>,
    scene: Scene,
    /// Assets with their twins.
    known: Vec<(Arc<Asset>, Arc<Asset>)>,
}

impl Twins {
    fn all() -> Vec<Self> {
        let twins = |name, make| Self {
            name,
            make,
            scene: Scene::new(),
            known: Vec::new(),
        };
        vec![
            twins("kd-trees", kd_twin as fn(&Asset) -> Arc<Asset>),
            twins("nodes that follow", following_twin),
        ]
    }

    /// Brings them into the state of `scene`.
    fn commit(&mut self, scene: &Scene, actors: &[(InstanceId, Arc<Asset>, Affine)]) -> Frame<'_> {
        let exists = |(instance, ..): &&(InstanceId, Arc<Asset>, Affine)| self.scene.state(*instance).is_ok();
        let present = actors.iter().filter(exists).count();
        for (instance, asset, _) in actors.iter().skip(present) {
            let known = self.known.iter().find(|(own, _)| Arc::ptr_eq(own, asset));
            let twin = known.map_or_else(|| (self.make)(asset), |(_, twin)| Arc::clone(twin));
            if known.is_none() {
                self.known.push((Arc::clone(asset), Arc::clone(&twin)));
            }
            let added = self.scene.add(&twin);
            assert_eq!(added, *instance, "the same order");
            self.scene.set_posing(added, Posing::Recomputed).unwrap();
        }
        for (instance, ..) in actors {
            let state = scene.state(*instance).unwrap();
            self.scene.set_state(*instance, &state).unwrap();
        }
        self.scene.commit()
    }
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
        let poses: Vec<(Vec<Affine>, Vec<f32>)> = self
            .actors
            .iter()
            .map(|(instance, ..)| {
                self.scene
                    .pose(*instance)
                    .map_or_else(|_| Default::default(), |pose| (pose.palette, pose.morph_weights))
            })
            .collect();
        let frame = self.scene.commit();
        let instances: Vec<InstanceId> = self.actors.iter().map(|(instance, ..)| *instance).collect();
        let oracle = Oracle::new(&frame, &instances);
        let mut marks = Landmarks::default();
        for ((instance, asset, transform), (palette, morph_weights)) in self.actors.iter().zip(&poses) {
            marks.add(&frame, *instance, asset, (palette, morph_weights), *transform);
        }
        (frame, oracle, marks)
    }

    /// Compares so many ordinary rays and so many aimed ones with brute force; the number of hits.
    ///
    /// # Panics
    /// Where they differ by a bit.
    pub fn assert_equals_brute_force(&mut self, name: &str, rays: usize, seed: u64) -> usize {
        let mut twins = std::mem::take(&mut self.twins);
        if twins.is_empty() {
            twins = Twins::all();
        }
        let twin_frames: Vec<(&str, Frame)> = twins
            .iter_mut()
            .map(|twins| (twins.name, twins.commit(&self.scene, &self.actors)))
            .collect();
        let (frame, oracle, marks) = self.commit();
        let ordinary = Rays::new(&oracle, seed).take(rays);
        let aimed = (!marks.triangles.is_empty()).then(|| AimedRays::new(&marks, seed).take(rays));
        let rays: Vec<Ray> = ordinary.chain(aimed.into_iter().flatten()).collect();
        let hits = assert_rays_equal(name, &frame, &oracle, rays.iter().copied());
        let fans = fans(&rays, seed);
        let alone: Vec<Option<Hit>> = fans.iter().map(|ray| frame.closest_hit(ray)).collect();
        for (name, frame) in twin_frames
            .iter()
            .map(|(name, frame)| (*name, frame))
            .chain([(name, &frame)])
        {
            let mut together = vec![None; fans.len()];
            frame.closest_hits(&fans, &mut together);
            let mut any = vec![false; fans.len()];
            frame.any_hits(&fans, &mut any);
            for (place, ray) in fans.iter().enumerate() {
                let expected = hit_bits(alone[place]);
                assert_eq!(hit_bits(together[place]), expected, "{name}: {ray:?}, place {place}");
                assert_eq!(any[place], expected.is_some(), "{name}: {ray:?}, place {place}");
            }
        }
        for ray in &rays {
            let expected = hit_bits(frame.closest_hit(ray));
            for (twin, frame) in &twin_frames {
                assert_eq!(hit_bits(frame.closest_hit(ray)), expected, "{name}, {twin}: {ray:?}");
            }
        }
        drop(twin_frames);
        self.twins = twins;
        hits
    }
}

/// Around some of these rays, the first of each: 64 that run nearly the same way, as a batch takes them together.
fn fans(rays: &[Ray], seed: u64) -> Vec<Ray> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut out = Vec::new();
    for ray in rays.iter().step_by(40) {
        let apart = [1e-7, 1e-4, 1e-2][random.usize(..3)];
        out.push(*ray);
        for _ in 1..64 {
            let longest = ray.direction.iter().fold(0.0f32, |longest, d| longest.max(d.abs()));
            let mut near = |x: f32| x + longest * apart * (random.f32() - 0.5);
            out.push(Ray {
                direction: ray.direction.map(&mut near),
                ..*ray
            });
        }
    }
    out
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
