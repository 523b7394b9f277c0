//! Options that choose clips and classes.

use restpose_bake::{
    BakeError, BakeSettings, ClipSelection, MotionClass, NoProgress, bake,
    import::import,
    verify::{VerifySettings, verify},
};
use restpose_runtime::{Asset, Scene};
use restpose_tests::{Recipe, random_animation, sample_scenes};
use std::sync::Arc;

const QUICK: VerifySettings = VerifySettings {
    rays: 2_000,
    poses: 8,
    pose_source: None,
    seed: 1,
};

/// Three clips, two of them without a name: each can be chosen, and is then the one that is played and verified.
#[test]
fn clips_without_names_are_chosen_by_number() {
    let recipe = Recipe {
        seed: 9,
        vertices: 40,
        joints: 4,
        scale: 1.0,
        offset: 0.0,
        wild_scales: false,
        morph_targets: 0,
    };
    let mut animation = random_animation(&recipe);
    for (number, name) in ["", "named", ""].into_iter().enumerate() {
        let other = random_animation(&Recipe {
            seed: 10 + number as u64,
            ..recipe
        });
        let mut clip = other.clips[0].clone();
        clip.name = name.to_owned();
        animation.clips.insert(number, clip);
    }
    animation.clips.truncate(3);
    for (choice, expected) in [("0", 0), ("named", 1), ("1", 1), ("2", 2)] {
        let settings = BakeSettings {
            clips: ClipSelection::Named(vec![choice.to_owned()]),
            ..BakeSettings::default()
        };
        let baked = bake(&animation, &settings, &NoProgress).unwrap();
        assert_eq!(baked.model.meta.clip_names, [animation.clips[expected].label(expected)]);
        let rotation = animation.clips[expected].channels[0].values[..4].to_vec();
        assert!(baked.model.key_values.starts_with(&rotation), "clip {choice}");
        let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap());
        let report = verify(&asset, &animation, &QUICK, &NoProgress).unwrap();
        assert_eq!((report.missed, report.wrong), (0, 0));
        assert!(
            report.max_vertex_error < 2e-6,
            "clip {choice}: {}",
            report.max_vertex_error
        );
    }
    let unknown = BakeSettings {
        clips: ClipSelection::Named(vec!["3".to_owned()]),
        ..BakeSettings::default()
    };
    match bake(&animation, &unknown, &NoProgress) {
        Err(BakeError::UnknownClip { name, known }) => assert_eq!((name.as_str(), known.len()), ("3", 3)),
        other => panic!("{other:?}"),
    }
}

/// A skinned part can be frozen, a static one can keep a bone; nothing else can be asked for.
#[test]
fn classes_can_be_asked_for_where_they_hold() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("mixed.glb"))
        .unwrap();
    let animation = import(&path).unwrap().animation;
    let plain = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap().report;
    let named = |class: MotionClass| {
        plain
            .parts
            .iter()
            .find(|part| part.class == class)
            .unwrap()
            .name
            .clone()
    };
    let (skinned, stays) = (named(MotionClass::Skinned), named(MotionClass::Static));

    let overrides = vec![
        (skinned.clone(), MotionClass::Static),
        (stays.clone(), MotionClass::Rigid),
    ];
    let settings = BakeSettings {
        class_overrides: overrides,
        ..BakeSettings::default()
    };
    let baked = bake(&animation, &settings, &NoProgress).unwrap();
    let class_of = |name: &str| baked.report.parts.iter().find(|part| part.name == name).unwrap().class;
    assert_eq!(
        (class_of(&skinned), class_of(&stays)),
        (MotionClass::Static, MotionClass::Rigid)
    );
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap());
    let report = verify(&asset, &animation, &QUICK, &NoProgress).unwrap();
    assert_eq!((report.missed, report.wrong), (0, 0));
    assert!(report.max_vertex_error < 2e-6, "{}", report.max_vertex_error);

    let wish = vec![(stays, MotionClass::Skinned)];
    let settings = BakeSettings {
        class_overrides: wish,
        ..BakeSettings::default()
    };
    assert!(matches!(
        bake(&animation, &settings, &NoProgress),
        Err(BakeError::Class { .. })
    ));
    let settings = BakeSettings {
        class_overrides: vec![("nobody".to_owned(), MotionClass::Static)],
        ..BakeSettings::default()
    };
    assert!(matches!(
        bake(&animation, &settings, &NoProgress),
        Err(BakeError::UnknownPart { .. })
    ));
}

/// A bake without clips has one sample, the pose without any.
#[test]
fn a_source_without_clips_bakes_its_default_pose() {
    let mut animation = import(&sample_scenes()[0]).unwrap().animation;
    animation.clips.clear();
    let baked = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap();
    assert_eq!(baked.model.samples.len(), 1);
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap());
    let report = verify(&asset, &animation, &QUICK, &NoProgress).unwrap();
    assert_eq!((report.missed, report.wrong), (0, 0));
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    assert!(scene.play(instance, 0, 0.0).is_err());
}

#[test]
fn sample_steps_that_are_no_steps_are_refused() {
    let animation = import(&sample_scenes()[0]).unwrap().animation;
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let settings = BakeSettings {
            sample_step_seconds: step,
            ..BakeSettings::default()
        };
        assert!(
            matches!(
                bake(&animation, &settings, &NoProgress),
                Err(BakeError::SampleStep { .. })
            ),
            "{step}"
        );
    }
    let settings = BakeSettings {
        sample_step_seconds: 1e-12,
        ..BakeSettings::default()
    };
    assert!(matches!(
        bake(&animation, &settings, &NoProgress),
        Err(BakeError::TooManySamples { .. })
    ));
}
