use super::*;
use crate::{
    BakeSettings, NoProgress, bake,
    import::{Animation, import},
};
use restpose_formats::rows::SampleRow;
use std::path::Path;

/// Skinned, morphing and rigid samples.
const SCENES: [&str; 4] = ["walker.glb", "tentacle.gltf", "machine.gltf", "mixed.glb"];

fn baked(name: &str) -> (Animation, Arc<Asset>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
    let animation = import(&folder.join(name)).unwrap().animation;
    let baked = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap();
    let asset = Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap();
    (animation, Arc::new(asset))
}

fn drawn(animation: &Animation, asset: &Asset, source: PoseSource, seed: u64, count: u64) -> Vec<DrawnPose> {
    let mut poses = Poses::new(animation, asset.model(), source, seed, count);
    (0..count).map(|index| poses.pose(index)).collect()
}

/// The maps of a clip's pose, taken from the runtime and given to the source, pose it as the clip does; a map that is off
/// shows.
#[test]
fn the_source_takes_given_maps() {
    for name in SCENES {
        let (animation, asset) = baked(name);
        let mut source = SourcePose::new(&animation, asset.model());
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        for pose in drawn(&animation, &asset, PoseSource::Clips, 1, 6) {
            pose.set(&mut scene, instance).unwrap();
            let mut palette = scene.pose(instance).unwrap().palette;
            let morph_weights = scene.pose(instance).unwrap().morph_weights;
            let frame = scene.commit();
            // A few roundings to `f32` of numbers a few times the model's size.
            let limit = 2e-6;
            let played = source.greatest_error(&frame, instance, &pose.bones, &pose.cache_frames);
            assert!(played < limit, "{name}: {played}");
            let given = BonePose::Palette {
                palette: palette.clone(),
                morph_weights: morph_weights.clone(),
            };
            let found = source.greatest_error(&frame, instance, &given, &pose.cache_frames);
            assert!(found < limit, "{name}: {found}");

            let moved = 0.01 * source.size() as f32;
            palette.iter_mut().for_each(|map| map.columns[3][0] += moved);
            let off = BonePose::Palette { palette, morph_weights };
            let found = source.greatest_error(&frame, instance, &off, &pose.cache_frames);
            assert!(found > 1e-3, "{name}: {found}");
        }
    }
}

#[test]
fn vertices_of_random_poses_are_the_sources() {
    for name in SCENES {
        let (animation, asset) = baked(name);
        let mut source = SourcePose::new(&animation, asset.model());
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        for pose in drawn(&animation, &asset, PoseSource::Random, 5, 44) {
            pose.set(&mut scene, instance).unwrap();
            let error = source.greatest_error(&scene.commit(), instance, &pose.bones, &pose.cache_frames);
            // As above; scales of up to 64 in joints at some distance from the origin make the numbers larger.
            assert!(error < 1e-5, "{name}, {:?}: {error}", pose.family);
        }
    }
}

#[test]
fn poses_depend_on_the_seed_and_their_number() {
    let (animation, asset) = baked("mixed.glb");
    for source in [PoseSource::Clips, PoseSource::Random] {
        let poses = drawn(&animation, &asset, source, 3, 40);
        assert_eq!(poses, drawn(&animation, &asset, source, 3, 40));
        assert_eq!(poses[..7], drawn(&animation, &asset, source, 3, 7));
        let other = drawn(&animation, &asset, source, 4, 40);
        assert!(poses.iter().zip(&other).any(|(pose, other)| pose.bones != other.bones));
        // Seeds next to each other do not share poses under other numbers.
        assert!(
            poses
                .iter()
                .all(|pose| other.iter().all(|other| pose.ray_seed != other.ray_seed))
        );
    }
}

#[test]
fn every_fourth_time_of_a_clip_is_a_key() {
    let (animation, asset) = baked("walker.glb");
    let model = asset.model();
    let is_key = |at: &SampleRow| {
        let clip = &model.clips[at.clip as usize];
        assert!((clip.start_seconds..=clip.end_seconds).contains(&at.seconds));
        model.key_times.contains(&at.seconds)
    };
    let poses = drawn(&animation, &asset, PoseSource::Clips, 1, 400);
    let keys = poses
        .iter()
        .filter(|pose| matches!(&pose.bones, BonePose::Clip(at) if is_key(at)));
    let keys: Vec<_> = keys.collect();
    assert_eq!(keys.len(), 100, "no time between keys is one by chance with this seed");
    for transformed in [false, true] {
        assert!(
            keys.iter()
                .any(|pose| (pose.transform != Affine::IDENTITY) == transformed)
        );
    }
}

/// Each family does what it says to the palette of some pose of the clips.
#[test]
fn families_take_turns_and_leave_the_clips() {
    let (animation, asset) = baked("mixed.glb");
    let size = SourcePose::new(&animation, asset.model()).size() as f32;
    let poses = drawn(&animation, &asset, PoseSource::Random, 2, 220);
    let mut weights = (0.0f32, 0.0f32);
    for (pose, family) in poses.iter().zip(PoseFamily::ALL.iter().cycle()) {
        assert_eq!(pose.family, Some(*family), "mixed.glb has what every family needs");
        let BonePose::Palette { palette, morph_weights } = &pose.bones else {
            panic!("a random pose has a palette");
        };
        assert!(palette.iter().all(Affine::is_finite));
        let distance = |map: &Affine| map.columns[3].iter().fold(0.0f32, |most, x| most.max(x.abs()));
        let far = palette.iter().filter(|map| distance(map) > 500.0 * size).count();
        assert_eq!(far, usize::from(*family == PoseFamily::Far), "{family:?}");
        let singular = palette
            .iter()
            .filter(|map| restpose_runtime::invert_frame(map).is_none());
        match family {
            PoseFamily::Vanished => assert_eq!(singular.count(), 1),
            PoseFamily::NearSingular | PoseFamily::Blend => {}
            _ => assert_eq!(singular.count(), 0, "{family:?}"),
        }
        if *family == PoseFamily::Morphs {
            let ends = morph_weights.iter().copied();
            weights = ends.fold(weights, |(low, high), x| (low.min(x), high.max(x)));
        }
    }
    assert!(
        (-2.0..-1.5).contains(&weights.0) && (2.5..=3.0).contains(&weights.1),
        "{weights:?}"
    );
    for family in PoseFamily::ALL {
        for transformed in [false, true] {
            let found = poses
                .iter()
                .any(|pose| pose.family == Some(family) && (pose.transform != Affine::IDENTITY) == transformed);
            assert!(found, "{family:?}, transformed {transformed}");
        }
    }
}

#[test]
fn files_without_morph_targets_have_no_morphs() {
    let (animation, asset) = baked("machine.gltf");
    assert!(asset.model().morph_targets.is_empty());
    let poses = Poses::new(&animation, asset.model(), PoseSource::Random, 1, 1);
    assert!(!poses.families().contains(&PoseFamily::Morphs));
    assert_eq!(poses.families().len(), PoseFamily::ALL.len() - 1);
}
