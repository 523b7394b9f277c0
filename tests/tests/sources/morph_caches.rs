//! Morph targets that are baked as a vertex cache, where the user asks for it.

use restpose_bake::{
    BakeError, BakeSettings, MotionClass, NoProgress, bake,
    import::{Animation, ChannelTarget, import},
    verify::{VerifySettings, verify},
};
use restpose_formats::rows::{Interpolation, NONE};
use restpose_runtime::{Asset, Posing};
use restpose_tests::sample_scenes;
use std::sync::Arc;

/// Positions are rounded to 2⁻¹⁶ of the part's diagonal, and evaluated in `f32`.
const VERTEX_TOLERANCE: f64 = 2e-5;

fn asked(animation: &Animation, class: MotionClass, part: &str) -> Result<Arc<Asset>, BakeError> {
    let settings = BakeSettings {
        class_overrides: vec![(part.to_owned(), class)],
        ..BakeSettings::default()
    };
    let baked = bake(animation, &settings, &NoProgress)?;
    let bytes = restpose_formats::write(&baked.model)?;
    Ok(Arc::new(Asset::from_bytes(&bytes)?))
}

/// The samples whose parts morph without a skin, their weights interpolated linearly, with the number of such a part.
fn morphing() -> Vec<(Animation, usize)> {
    let scenes = sample_scenes();
    let imported = scenes.iter().map(|path| {
        let mut animation = import(path).unwrap().animation;
        let channels = animation.clips.iter_mut().flat_map(|clip| &mut clip.channels);
        for channel in channels.filter(|channel| channel.target == ChannelTarget::Weights) {
            if channel.interpolation == Interpolation::CubicSpline {
                let width = channel.values.len() / channel.times.len() / 3;
                let keys = channel.values.chunks(3 * width);
                channel.values = keys.flat_map(|key| key[width..2 * width].to_vec()).collect();
            }
            channel.interpolation = Interpolation::Linear;
        }
        animation
    });
    imported
        .filter_map(|animation| {
            let part = animation.parts.iter().position(|part| {
                part.skin.is_none() && part.cache.is_none() && animation.meshes[part.mesh].morph_target_count > 0
            })?;
            Some((animation, part))
        })
        .collect()
}

#[test]
fn a_morphing_part_can_be_keyframed_or_free_and_keeps_the_contract() {
    let scenes = morphing();
    assert!(!scenes.is_empty(), "a bundled sample morphs without a skin");
    for (animation, part) in scenes {
        let name = &animation.parts[part].name;
        for class in [MotionClass::Keyframed, MotionClass::Free] {
            let asset = asked(&animation, class, name).unwrap();
            let row = asset.model().parts[part];
            assert_ne!(row.cache, NONE);
            assert_eq!((row.class, row.morph_set), (class as u32, NONE));
            assert_eq!(row.source_mesh as usize, animation.parts[part].mesh);
            let settings = VerifySettings {
                rays: 6_000,
                poses: 24,
                pose_source: None,
                seed: 2,
            };
            let report = verify(&asset, &animation, &settings, &NoProgress).unwrap();
            assert_eq!((report.missed, report.wrong), (0, 0), "{name}: {:#?}", report.failures);
        }
    }
}

/// The clip of the cache is the clip of the weights: at the same times the vertices are where the morph targets put them.
#[test]
fn its_clips_play_as_before() {
    for (animation, part) in morphing() {
        let name = &animation.parts[part].name;
        let before = {
            let baked = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap();
            Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap())
        };
        let after = asked(&animation, MotionClass::Keyframed, name).unwrap();
        let mut scene = restpose_runtime::Scene::new();
        let (a, b) = (scene.add(&before), scene.add(&after));
        scene.set_posing(a, Posing::Recomputed).unwrap();
        scene.set_posing(b, Posing::Recomputed).unwrap();
        for (clip, row) in before.model().clips.iter().enumerate() {
            for step in 0..=20 {
                let seconds = row.start_seconds + (row.end_seconds - row.start_seconds) * step as f32 / 20.0;
                scene.play(a, clip, seconds).unwrap();
                scene.play(b, clip, seconds).unwrap();
                let frame = scene.commit();
                let bounds = frame.bounds();
                let size = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0f32, f32::max);
                let rows = before.model().parts[part];
                for vertex in rows.vertex_first..rows.vertex_first + rows.vertex_count {
                    let (p, q) = (frame.vertex(a, vertex).unwrap(), frame.vertex(b, vertex).unwrap());
                    let off = (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0f32, f32::max);
                    assert!(
                        f64::from(off) <= VERTEX_TOLERANCE * f64::from(size),
                        "{name} at {seconds} s: {off}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_is_skinned_cannot_be_keyframed() {
    let scenes = sample_scenes();
    let animation = scenes
        .iter()
        .map(|path| import(path).unwrap().animation)
        .find_map(|animation| {
            let part = animation.parts.iter().position(|part| part.skin.is_some())?;
            Some((animation.parts[part].name.clone(), animation))
        });
    let (name, animation) = animation.unwrap();
    let refused = asked(&animation, MotionClass::Keyframed, &name);
    assert!(matches!(refused, Err(BakeError::Class { .. })), "{:?}", refused.err());
}
