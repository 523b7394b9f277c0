//! Vertex caches posed whole, whose trees are joined anew where another segment has other ones.

use fastrand::Rng;
use restpose_bake::{BakeSettings, DecomposeSettings, NoProgress, bake};
use restpose_runtime::{Asset, Posing, Ray, Scene};
use restpose_tests::{CacheRecipe, Motion, random_cache};
use std::sync::Arc;

fn asset(seed: u64) -> Arc<Asset> {
    let animation = random_cache(&CacheRecipe {
        seed,
        frames: 13,
        parts: 2,
        pieces: 3,
        points: 12,
        bridges: 4,
        motions: Motion::ALL,
        residual: 0.05,
        offset: 0.0,
        moving_nodes: false,
        scale: 1.0,
    });
    let settings = BakeSettings {
        segments: 4,
        // Segments wherever they save anything.
        size_worth: 0.001,
        rays_per_frame: 0.0,
        motion: DecomposeSettings {
            max_clusters: 3,
            ..DecomposeSettings::default()
        },
        ..BakeSettings::default()
    };
    let model = bake(&animation, &settings, &NoProgress).expect("a scene").model;
    let bytes = restpose_formats::write(&model).expect("a model");
    Arc::new(Asset::from_bytes(&bytes).expect("a file"))
}

#[test]
fn whole_instances_are_hit_as_others_whichever_segment_they_come_from() {
    let mut random = Rng::with_seed(6);
    let (mut hits, mut changes) = (0, 0);
    for seed in 0..48 {
        let asset = asset(seed);
        let caches = asset.model().caches;
        changes += usize::from(caches.iter().any(|cache| cache.segment_count > 1));
        let (mut scene, mut other) = (Scene::new(), Scene::new());
        let (whole, recomputed) = (scene.add(&asset), other.add(&asset));
        scene.set_posing(whole, Posing::Whole).unwrap();
        other.set_posing(recomputed, Posing::Recomputed).unwrap();
        for _ in 0..12 {
            let frames: Vec<f64> = caches.iter().map(|_| 12.0 * random.f64()).collect();
            scene.set_cache_frames(whole, &frames).unwrap();
            other.set_cache_frames(recomputed, &frames).unwrap();
            let (frame, expected) = (scene.commit(), other.commit());
            let bounds = frame.bounds();
            let mut point = || -> [f32; 3] {
                std::array::from_fn(|k| bounds.min[k] + random.f32() * (bounds.max[k] - bounds.min[k]))
            };
            for _ in 0..60 {
                let ray = Ray::between(point(), point());
                let found = frame.closest_hit(&ray);
                assert_eq!(found, expected.closest_hit(&ray), "seed {seed}, frames {frames:?}");
                hits += usize::from(found.is_some());
            }
            assert_eq!(frame.stats().instances_whole, 1);
        }
    }
    assert!(hits > 3_000 && changes > 5, "{hits} hits, {changes} with segments");
}
