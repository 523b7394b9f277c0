//! The contract: hits equal brute force, bit for bit, in every pose that a file was baked for.

use proptest::{prelude::*, test_runner::RngSeed};
use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::Animation,
    verify::{Oracle, Rays, VerifyReport, VerifySettings, verify},
};
use restpose_runtime::{Affine, Asset, Hit, Ray, Scene};
use restpose_tests::{Recipe, baked_asset, random_animation, source_scenes};
use std::sync::Arc;

/// Vertices are evaluated in `f64` and rounded to `f32` a few times; eight chained roundings of numbers a few times the
/// model's size stay under this.
const VERTEX_TOLERANCE: f64 = 2e-6;

#[test]
fn hits_equal_brute_force_on_every_scene() {
    let scenes = source_scenes();
    assert!(!scenes.is_empty(), "the bundled samples are part of the repository");
    for path in scenes {
        let (animation, asset) = baked_asset(&path);
        let settings = VerifySettings {
            rays: 20_000,
            poses: 24,
            pose_source: None,
            seed: 7,
        };
        let report = verify(&asset, &animation, &settings, &NoProgress).unwrap();
        assert_eq!(
            (report.missed, report.wrong),
            (0, 0),
            "{}: {:#?}",
            path.display(),
            report.failures
        );
        assert!(
            report.hits > report.rays / 5,
            "{}: {} of {} rays hit",
            path.display(),
            report.hits,
            report.rays
        );
        assert!(
            report.max_vertex_error < VERTEX_TOLERANCE,
            "{}: {}",
            path.display(),
            report.max_vertex_error
        );
    }
}

fn verify_random(animation: &Animation, rays: u64) -> VerifyReport {
    let settings = BakeSettings {
        sample_step_seconds: 0.125,
        ..BakeSettings::default()
    };
    let baked = bake(animation, &settings, &NoProgress).unwrap();
    let bytes = restpose_formats::write(&baked.model).unwrap();
    let asset = Arc::new(Asset::from_bytes(&bytes).unwrap());
    verify(
        &asset,
        animation,
        &VerifySettings {
            rays,
            poses: 6,
            pose_source: None,
            seed: 3,
        },
        &NoProgress,
    )
    .unwrap()
}

proptest! {
    // The same cases every time; PROPTEST_CASES=100000 is a night's search.
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn hits_equal_brute_force_on_random_animations(
        seed in any::<u64>(),
        vertices in 3usize..60,
        joints in 1usize..7,
        exponent in -30i32..=30,
        offset in prop_oneof![Just(0.0f32), Just(10.0), Just(1e4), Just(1e7)],
        wild_scales in any::<bool>(),
        morph_targets in 0usize..3,
    ) {
        // With wild scales the hierarchy multiplies lengths by up to 40 per joint.
        let exponent = if wild_scales { exponent / 3 } else { exponent };
        let scale = 10f32.powi(if offset > 10.0 { exponent / 2 } else { exponent });
        let recipe = Recipe { seed, vertices, joints, scale, offset, wild_scales, morph_targets };
        let report = verify_random(&random_animation(&recipe), 1_000);
        prop_assert_eq!((report.missed, report.wrong), (0, 0), "{:?}: {:#?}", recipe, report.failures);
    }
}

/// Several instances of two assets that overlap, under transforms: hits, batches and any-hit answers agree with brute
/// force over all of them, and equal hits go to the lowest instance.
#[test]
fn overlapping_instances_equal_brute_force() {
    let scenes = source_scenes();
    let (_, first) = baked_asset(&scenes[0]);
    let (_, second) = baked_asset(&scenes[1]);
    let mut scene = Scene::new();
    let mut instances = Vec::new();
    for index in 0..6u8 {
        let asset = if index % 3 == 2 { &second } else { &first };
        let instance = scene.add(asset);
        // 0 and 1 stand on the very same place in the same pose.
        let shift = f32::from(index / 2) * 0.3;
        let mut transform = Affine::from_translation([shift, 0.0, -shift]);
        transform.columns[0][0] = if index == 4 { -1.0 } else { 1.0 };
        scene.set_transform(instance, transform).unwrap();
        let samples = asset.model().samples;
        let sample = samples[samples.len() / 2 + usize::from(index / 2)];
        scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        instances.push(instance);
    }
    let frame = scene.commit();
    assert_eq!(frame.stats().instances, 6);
    let oracle = Oracle::new(&frame, &instances);
    let rays: Vec<Ray> = Rays::new(&oracle, 5).take(4_000).collect();
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.closest_hit(ray)).collect();
    let mut hits = vec![None; rays.len()];
    frame.closest_hits(&rays, &mut hits);
    assert!(hits == expected);
    let mut occluded = vec![false; rays.len()];
    frame.any_hits(&rays, &mut occluded);
    assert!(occluded.iter().zip(&expected).all(|(any, hit)| *any == hit.is_some()));
    assert!(expected.iter().flatten().any(|hit| hit.instance == instances[0]));
    assert!(
        expected.iter().flatten().all(|hit| hit.instance != instances[1]),
        "1 hides behind 0, its equal"
    );
}

/// A palette taken from one instance and given to another poses it alike, bit for bit.
#[test]
fn external_palette_equals_clip() {
    let (_, asset) = baked_asset(&source_scenes()[0]);
    let mut scene = Scene::new();
    let (played, given) = (scene.add(&asset), scene.add(&asset));
    let sample = asset.model().samples[asset.model().samples.len() / 3];
    scene.play(played, sample.clip as usize, sample.seconds).unwrap();
    let palette = scene.palette(played).unwrap().to_vec();
    let weights = scene.morph_weights(played).unwrap().to_vec();
    scene.set_palette(given, &palette, &weights).unwrap();
    let frame = scene.commit();
    for vertex in 0..asset.model().vertices.len() as u32 {
        assert_eq!(frame.vertex(played, vertex), frame.vertex(given, vertex));
    }
}
