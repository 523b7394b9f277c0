//! The contract: hits equal brute force, bit for bit, in every pose that a file was baked for.

use proptest::{prelude::*, test_runner::RngSeed};
use restpose_bake::{
    BakeSettings, LimitSettings, NoProgress, PoseSpace,
    import::Animation,
    verify::{Oracle, PoseSource, Rays, VerifyReport, VerifySettings, verify},
};
use restpose_formats::{Bounds, TreeKind};
use restpose_runtime::{Affine, Asset, Hit, Posing, Ray, Scene};
use restpose_tests::{Recipe, baked_asset, baked_with, kd_twin, random_animation, source_scenes};
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
        let name = path.display().to_string();
        assert_equals_brute_force(&name, &animation, &asset);
        let settings = BakeSettings {
            tree: TreeKind::Kd,
            ..BakeSettings::default()
        };
        let name = format!("{name}, kd-trees");
        assert_equals_brute_force(&name, &animation, &baked_with(&animation, &settings));
    }
}

/// In the poses that the file was baked for: samples, or clips at any time.
#[track_caller]
fn assert_equals_brute_force(name: &str, animation: &Animation, asset: &Arc<Asset>) {
    let settings = VerifySettings {
        rays: 20_000,
        poses: 24,
        pose_source: None,
        seed: 7,
    };
    let report = verify(asset, animation, &settings, &NoProgress).unwrap();
    let expected = match asset.model().meta.bounds {
        Bounds::Sampled => PoseSource::Samples,
        Bounds::Envelope => PoseSource::Clips,
    };
    assert_eq!(report.pose_source, expected);
    let found = (report.missed, report.wrong);
    assert_eq!(found, (0, 0), "{name}: {:#?}", report.failures);
    assert!(
        report.hits > report.rays / 5,
        "{name}: {} of {} rays hit",
        report.hits,
        report.rays
    );
    assert!(
        report.max_vertex_error < VERTEX_TOLERANCE,
        "{name}: {}",
        report.max_vertex_error
    );
}

fn verify_random(
    animation: &Animation,
    settings: &BakeSettings,
    source: Option<PoseSource>,
    rays: u64,
) -> VerifyReport {
    let settings = BakeSettings {
        sample_step_seconds: 0.125,
        ..settings.clone()
    };
    let asset = baked_with(animation, &settings);
    let settings = VerifySettings {
        rays,
        poses: if source.is_some() { 22 } else { 6 },
        pose_source: source,
        seed: 3,
    };
    let report = verify(&asset, animation, &settings, &NoProgress).unwrap();
    let twin = verify(&kd_twin(&asset), animation, &settings, &NoProgress).unwrap();
    assert_eq!(
        (twin.missed, twin.wrong, twin.hits),
        (0, 0, report.hits),
        "kd-trees: {:#?}",
        twin.failures
    );
    report
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
        let scale = unit(exponent, offset, wild_scales);
        let recipe = Recipe { seed, vertices, joints, scale, offset, wild_scales, morph_targets };
        let report = verify_random(&random_animation(&recipe), &BakeSettings::default(), None, 1_000);
        prop_assert_eq!((report.missed, report.wrong), (0, 0), "{:?}: {:#?}", recipe, report.failures);
    }

    /// With envelopes in every pose, of the clips or far outside of them.
    #[test]
    fn hits_equal_brute_force_in_any_pose_of_random_animations(
        seed in any::<u64>(),
        vertices in 3usize..40,
        joints in 1usize..7,
        exponent in -30i32..=30,
        offset in prop_oneof![Just(0.0f32), Just(10.0), Just(1e4), Just(1e7)],
        wild_scales in any::<bool>(),
        morph_targets in 0usize..3,
        envelopes in prop_oneof![Just(1usize), Just(2), Just(16)],
        pose_space in prop_oneof![
            Just(PoseSpace::Clips),
            Just(PoseSpace::Arbitrary),
            Just(PoseSpace::Limits(LimitSettings::default())),
            Just(PoseSpace::Clip("clip".to_owned())),
        ],
        source in prop_oneof![Just(PoseSource::Clips), Just(PoseSource::Random), Just(PoseSource::Random)],
    ) {
        let scale = unit(exponent, offset, wild_scales);
        let recipe = Recipe { seed, vertices, joints, scale, offset, wild_scales, morph_targets };
        let settings = BakeSettings {
            bounds: Bounds::Envelope,
            pose_samples: pose_space.is_random().then_some(30),
            pose_space,
            envelopes,
            ..BakeSettings::default()
        };
        let report = verify_random(&random_animation(&recipe), &settings, Some(source), 1_100);
        prop_assert_eq!((report.missed, report.wrong), (0, 0), "{:?}, {:?}: {:#?}", recipe, settings, report.failures);
    }
}

/// Unit of a recipe's lengths: with wild scales the hierarchy multiplies them by up to 40 per joint.
fn unit(exponent: i32, offset: f32, wild_scales: bool) -> f32 {
    let exponent = if wild_scales { exponent / 3 } else { exponent };
    10f32.powi(if offset > 10.0 { exponent / 2 } else { exponent })
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
        let posings = [Posing::Recomputed, Posing::Remembered, Posing::Whole, Posing::Chosen];
        scene.set_posing(instance, posings[index as usize % 4]).unwrap();
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
    let palette = scene.pose(played).unwrap().palette;
    let weights = scene.pose(played).unwrap().morph_weights;
    scene.set_palette(given, &palette, &weights).unwrap();
    let frame = scene.commit();
    for vertex in 0..asset.model().vertices.len() as u32 {
        assert_eq!(frame.vertex(played, vertex), frame.vertex(given, vertex));
    }
}
