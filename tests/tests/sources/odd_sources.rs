//! Sources and settings that nobody would choose but exporters and scripts write.

use restpose_bake::{
    BakeSettings, MotionClass, NoProgress, bake,
    import::{Animation, Channel, ChannelTarget},
    verify::{VerifyReport, VerifySettings, verify},
};
use restpose_formats::{Model, rows::Interpolation};
use restpose_runtime::Asset;
use restpose_tests::{Recipe, random_animation};
use std::sync::Arc;

const RECIPE: Recipe = Recipe {
    seed: 4,
    vertices: 40,
    joints: 4,
    scale: 1.0,
    offset: 0.0,
    wild_scales: false,
    morph_targets: 0,
};

fn verified(model: &Model, animation: &Animation) -> VerifyReport {
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(model).unwrap()).unwrap());
    let settings = VerifySettings {
        rays: 4_000,
        poses: 8,
        pose_source: None,
        seed: 2,
    };
    verify(&asset, animation, &settings, &NoProgress).unwrap()
}

/// A shape key that was never sculpted, animated all the same.
#[test]
fn animated_morph_targets_that_move_nothing_are_baked() {
    let mut animation = random_animation(&RECIPE);
    let mesh = &mut animation.meshes[0];
    mesh.morph_target_count = 1;
    mesh.primitives[0].morph_targets = vec![vec![[0.0; 3]; RECIPE.vertices]];
    animation.nodes[0].weights = vec![0.0];
    animation.clips[0].channels.push(Channel {
        node: 0,
        target: ChannelTarget::Weights,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.5],
        values: vec![0.0, 1.0],
    });
    let baked = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap();
    let report = verified(&baked.model, &animation);
    assert_eq!((report.missed, report.wrong), (0, 0));
}

/// Each class is asked for against what the baker found, not against what was asked before.
#[test]
fn a_class_asked_for_twice_is_judged_by_the_source() {
    let animation = random_animation(&RECIPE);
    let part = animation.parts[0].name.clone();
    let settings = BakeSettings {
        class_overrides: vec![(part.clone(), MotionClass::Static), (part, MotionClass::Rigid)],
        ..BakeSettings::default()
    };
    // Refused, or baked so that no hit is missed: a skinned part is not rigid.
    if let Ok(baked) = bake(&animation, &settings, &NoProgress) {
        let report = verified(&baked.model, &animation);
        assert_eq!((report.missed, report.wrong), (0, 0), "{:#?}", report.failures);
    }
}

/// The format allows a file without samples; there is then nothing to verify, and nothing to panic about.
#[test]
fn a_file_without_samples_is_verified() {
    let animation = random_animation(&RECIPE);
    let mut model = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap().model;
    model.samples.clear();
    let report = verified(&model, &animation);
    assert_eq!((report.missed, report.wrong), (0, 0));
}
