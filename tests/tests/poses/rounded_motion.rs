//! Numbers between two states are rounded: what that does to vertices does not take them out of reach of rays.

use restpose_bake::{BakeSettings, MotionClass, import::import, verify::Oracle};
use restpose_runtime::{Affine, Asset, InstanceId, Ray, Scene};
use restpose_tests::{CacheRecipe, baked_with, random_cache, sample_scenes};
use std::sync::Arc;

/// Rays across the outermost vertices of an instance that moves by nothing but rounding. How many hit.
fn assert_met(name: &str, asset: &Arc<Asset>, transform: Affine, pose: impl Fn(&mut Scene, InstanceId)) -> u32 {
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    scene.set_transform(instance, transform).unwrap();
    pose(&mut scene, instance);
    let state = scene.state(instance).unwrap();
    scene.set_motion(instance, Some(&state)).unwrap();
    let frame = scene.commit();
    let mut random = fastrand::Rng::with_seed(1);
    let mut hits = 0;
    for time in [0.1, 0.3, 0.5, 0.9, random.f32()] {
        let mut still = Scene::new();
        let twin = still.add(asset);
        still.set_state(twin, &frame.state_at(instance, time).unwrap()).unwrap();
        let still = still.commit();
        let oracle = Oracle::new(&still, &[twin]);
        let triangles: Vec<_> = (0..).map_while(|triangle| still.triangle(twin, triangle)).collect();
        for (axis, sign) in [(0, -1.0f32), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)] {
            let along = |corner: &[f32; 3]| sign * corner[axis];
            let corners = triangles
                .iter()
                .flat_map(|corners| corners.map(|corner| (corner, corners)));
            let (corner, corners) = corners.max_by(|(a, _), (b, _)| along(a).total_cmp(&along(b))).unwrap();
            for inward in [0.0f32, 1e-5, 1e-3] {
                let middle = |k: usize| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0;
                let target: [f32; 3] = std::array::from_fn(|k| corner[k] + inward * (middle(k) - corner[k]));
                let size = (0..3).map(|k| (middle(k) - corner[k]).abs()).fold(0.0, f32::max);
                let mut direction: [f32; 3] = std::array::from_fn(|_| random.f32() - 0.5);
                direction[axis] = 0.0;
                let ray = Ray::new(std::array::from_fn(|k| target[k] - size * direction[k]), direction);
                let expected = oracle.closest_hit(&ray);
                assert_eq!(
                    frame.closest_hit_at(&ray, time),
                    expected,
                    "{name}, time {time}: {ray:?}"
                );
                hits += u32::from(expected.is_some());
            }
        }
    }
    hits
}

/// A transform takes back where the cache stands, so that the rest is small beside what rounding adds.
#[test]
fn free_motion_far_from_the_origin_of_its_cache() {
    let mut hits = 0;
    for seed in 0..8 {
        let animation = random_cache(&CacheRecipe {
            seed,
            offset: 1e4,
            ..CacheRecipe::default()
        });
        let parts = animation.parts.iter();
        let settings = BakeSettings {
            class_overrides: parts.map(|part| (part.name.clone(), MotionClass::Free)).collect(),
            rays_per_frame: 0.0,
            ..BakeSettings::default()
        };
        let asset = baked_with(&animation, &settings);
        let scale = 1.5791;
        let offset = [-15_791.3, -15_790.9, -15_791.1];
        let transform = Affine {
            columns: [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale], offset],
        };
        let frames = vec![1.2215; asset.model().caches.len()];
        hits += assert_met(&format!("seed {seed}"), &asset, transform, |scene, instance| {
            scene.set_cache_frames(instance, &frames).unwrap();
        });
    }
    assert!(hits > 100, "{hits}");
}

/// Half of three least steps and half again are four.
#[test]
fn transforms_of_least_numbers() {
    let scaled = |by: f32| Affine {
        columns: [[by, 0.0, 0.0], [0.0, by, 0.0], [0.0, 0.0, by], [0.0; 3]],
    };
    let mut hits = 0;
    for path in sample_scenes() {
        let asset = baked_with(&import(&path).unwrap().animation, &BakeSettings::default());
        let model = asset.model();
        if !model.caches.is_empty() {
            continue;
        }
        let (palette, weights) = (
            vec![scaled(1e36); model.bones.len()],
            vec![0.0; model.morph_targets.len()],
        );
        let name = path.display().to_string();
        hits += assert_met(&name, &asset, scaled(f32::from_bits(3)), |scene, instance| {
            scene.set_palette(instance, &palette, &weights).unwrap();
        });
    }
    assert!(hits > 20, "{hits}");
}
