//! Poses inside and outside of what a file was baked for.

use restpose_bake::{
    BakeSettings, PoseSpace,
    import::{Animation, import},
    verify::{DrawnPose, Oracle, PoseFamily, PoseSource, Poses, Rays},
};
use restpose_formats::Bounds;
use restpose_runtime::{Asset, Frame, FrameStats, Hit, InstanceId, PoseError, Posing, Ray, Scene};
use restpose_tests::{Recipe, baked_with, random_animation, sample_scenes, source_scenes};
use std::{path::Path, sync::Arc};

fn enveloped(path: &Path, envelopes: usize) -> (Animation, Arc<Asset>) {
    let settings = BakeSettings {
        bounds: Bounds::Envelope,
        envelopes,
        ..BakeSettings::default()
    };
    let animation = import(path).unwrap().animation;
    let asset = baked_with(&animation, &settings);
    (animation, asset)
}

fn walker() -> (Animation, Arc<Asset>) {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    enveloped(&path, 16)
}

/// Poses of one family.
fn of_family(animation: &Animation, asset: &Asset, family: PoseFamily, count: u64) -> Vec<DrawnPose> {
    let mut poses = Poses::new(animation, asset.model(), PoseSource::Random, 8, 20 * count);
    let drawn = (0..20 * count).map(|index| poses.pose(index));
    let out: Vec<_> = drawn
        .filter(|pose| pose.family == Some(family))
        .take(count as usize)
        .collect();
    assert_eq!(out.len(), count as usize);
    out
}

/// Hits of rays around the scene, each compared with brute force, and the frame's statistics.
#[track_caller]
fn traced(frame: &Frame, instances: &[InstanceId]) -> (Vec<Option<Hit>>, FrameStats) {
    let oracle = Oracle::new(frame, instances);
    let rays: Vec<Ray> = Rays::new(&oracle, 9).take(400).collect();
    let hits: Vec<Option<Hit>> = rays.iter().map(|ray| frame.closest_hit(ray)).collect();
    for (ray, hit) in rays.iter().zip(&hits) {
        assert_eq!(*hit, oracle.closest_hit(ray), "{ray:?}");
    }
    assert!(hits.iter().flatten().count() > 40);
    frame.prepare();
    (hits, frame.stats())
}

/// The continuous motion of every clip is inside its pose space, at times that no sample knows: the file says so, and its
/// palettes are found to be when they are measured, as those of callers are.
#[test]
fn clips_never_leave_their_pose_space() {
    for path in source_scenes() {
        for envelopes in [1, 5, 16] {
            let (_, asset) = enveloped(&path, envelopes);
            let model = asset.model();
            assert!(
                model.pose_spaces.iter().all(|space| space.clips_inside == 1),
                "{}",
                path.display()
            );
            let mut random = fastrand::Rng::with_seed(3);
            let mut scene = Scene::new();
            let instance = scene.add(&asset);
            scene.set_posing(instance, Posing::Recomputed).unwrap();
            for clip in 0..model.clips.len() {
                let row = model.clips[clip];
                for _ in 0..300 {
                    let seconds = row.start_seconds + random.f32() * (row.end_seconds - row.start_seconds);
                    scene.play(instance, clip, seconds).unwrap();
                    assert!(scene.commit_inside().is_ok());
                    let known: Vec<[f64; 3]> = scene.commit().clusters().map(|cluster| cluster.excess).collect();
                    let pose = scene.pose(instance).unwrap();
                    scene.set_palette(instance, &pose.palette, &pose.morph_weights).unwrap();
                    let frame = scene.commit();
                    let measured: Vec<[f64; 3]> = frame.clusters().map(|cluster| cluster.excess).collect();
                    let at = format!(
                        "{} in {envelopes} envelopes: clip {clip} at {seconds} s: {:?}",
                        path.display(),
                        frame.stats()
                    );
                    assert_eq!(frame.stats().clusters_outside, 0, "{at}");
                    assert_eq!(known, measured, "{at}");
                }
            }
        }
    }
}

/// Linear, stepping and cubic channels, beside their keys.
#[test]
fn clips_of_soups_never_leave_their_pose_space() {
    let mut known = 0;
    for seed in 0..24 {
        let recipe = Recipe {
            seed,
            vertices: 12,
            joints: 3,
            scale: 1.0,
            offset: 0.0,
            wild_scales: false,
            morph_targets: 3,
        };
        let asset = baked_with(&random_animation(&recipe), &BakeSettings::default());
        let model = asset.model();
        known += model.pose_spaces.iter().filter(|space| space.clips_inside == 1).count();
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        let excess =
            |scene: &mut Scene| -> Vec<[f64; 3]> { scene.commit().clusters().map(|cluster| cluster.excess).collect() };
        for clip in 0..model.clips.len() {
            for key in model.key_times {
                for seconds in [
                    key.next_down().next_down(),
                    key.next_down(),
                    *key,
                    key.next_up(),
                    key + 1e-3,
                ] {
                    scene.play(instance, clip, seconds).unwrap();
                    let as_clip = excess(&mut scene);
                    let pose = scene.pose(instance).unwrap();
                    scene.set_palette(instance, &pose.palette, &pose.morph_weights).unwrap();
                    assert_eq!(as_clip, excess(&mut scene), "seed {seed}, clip {clip} at {seconds} s");
                }
            }
        }
    }
    assert!(known > 24, "{known}");
}

/// Where boxes are made for one of the clips, nothing is known of the others.
#[test]
fn clips_that_boxes_were_not_made_for_are_measured() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let animation = import(&path).unwrap().animation;
    let name = animation.clips[0].name.clone();
    let settings = BakeSettings {
        pose_space: PoseSpace::Clip(name),
        ..BakeSettings::default()
    };
    let asset = baked_with(&animation, &settings);
    let model = asset.model();
    assert!(model.clips.len() > 1);
    assert!(model.pose_spaces.iter().all(|space| space.clips_inside == 0));
}

/// Who asks for poses of the pose space alone gets a typed error for others, and nothing stale afterwards.
#[test]
fn poses_outside_are_refused_where_the_caller_asks_for_it() {
    let (animation, asset) = walker();
    let model = asset.model();
    let mut scene = Scene::new();
    let (other, walker) = (scene.add(&asset), scene.add(&asset));
    scene.set_posing(other, Posing::Recomputed).unwrap();
    scene.set_posing(walker, Posing::Recomputed).unwrap();
    scene.play(walker, 0, 0.3).unwrap();
    scene.play(other, 0, 0.1).unwrap();
    let expected = traced(&scene.commit_inside().unwrap(), &[other, walker]);
    assert!(expected.1.clusters_outside == 0);

    for pose in of_family(&animation, &asset, PoseFamily::Ragdoll, 5) {
        pose.set(&mut scene, walker).unwrap();
        let Err(PoseError::OutsidePoseSpace {
            instance,
            bone,
            name,
            excess,
        }) = scene.commit_inside()
        else {
            panic!("ragdolls are outside");
        };
        assert_eq!((instance, &name), (1, &model.meta.bone_names[bone]));
        assert!(excess > 0.0 && excess.is_finite(), "{excess}");
        // The first cluster outside, with what it would be widened by.
        let frame = scene.commit();
        frame.prepare();
        let stats = frame.stats();
        assert!(stats.clusters_outside > 0 && f64::from(stats.largest_excess) >= excess * (1.0 - 1e-6));
        let widest = |excess: [f64; 3]| excess.into_iter().fold(0.0, f64::max);
        let named = frame
            .clusters()
            .find(|cluster| cluster.instance == walker && widest(cluster.excess) == excess);
        assert_eq!(model.clusters[named.unwrap().cluster as usize].bone as usize, bone);

        // Refused again, as often as one asks; then the pose before traces as before.
        assert!(scene.commit_inside().is_err());
        scene.play(walker, 0, 0.3).unwrap();
        assert_eq!(traced(&scene.commit_inside().unwrap(), &[other, walker]), expected);
    }
}

/// Palettes that are none leave the instance as it stands, also outside of its pose space.
#[test]
fn refused_palettes_leave_nothing_stale() {
    let (animation, asset) = walker();
    let names = &asset.model().meta.bone_names;
    let mut scene = Scene::new();
    let walker = scene.add(&asset);
    scene.set_posing(walker, Posing::Recomputed).unwrap();
    let poses = of_family(&animation, &asset, PoseFamily::Ragdoll, 2);
    poses[0].set(&mut scene, walker).unwrap();
    let palette = scene.pose(walker).unwrap().palette;
    let expected = traced(&scene.commit(), &[walker]);
    poses[1].set(&mut scene, walker).unwrap();
    let good = scene.pose(walker).unwrap().palette;
    poses[0].set(&mut scene, walker).unwrap();

    for length in [0, good.len() - 1, good.len() + 1] {
        let given = good.iter().cycle().take(length).copied().collect::<Vec<_>>();
        let (expected, found) = (good.len(), length);
        assert_eq!(
            scene.set_palette(walker, &given, &[]),
            Err(PoseError::PaletteLength { expected, found })
        );
    }
    for (bone, entry, value) in [
        (1, 0, f32::NAN),
        (3, 7, f32::INFINITY),
        (good.len() - 1, 11, f32::NEG_INFINITY),
    ] {
        let mut given = good.clone();
        given[bone].columns[entry / 3][entry % 3] = value;
        let name = names[bone].clone();
        assert_eq!(
            scene.set_palette(walker, &given, &[]),
            Err(PoseError::BoneNotFinite { bone, name })
        );
    }
    assert_eq!(scene.pose(walker).unwrap().palette, palette);
    assert_eq!(traced(&scene.commit(), &[walker]), expected);
}

/// A pose's statistics and hits are its own, whatever was posed and traced before it.
#[test]
fn poses_do_not_depend_on_the_poses_before_them() {
    for path in sample_scenes() {
        let (animation, asset) = enveloped(&path, 16);
        let mut clips = Poses::new(&animation, asset.model(), PoseSource::Clips, 5, 30);
        let mut random = Poses::new(&animation, asset.model(), PoseSource::Random, 5, 30);
        let poses: Vec<DrawnPose> = (0..30)
            .flat_map(|index| [clips.pose(index), random.pose(index)])
            .collect();
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        let mut outside = 0;
        for pose in &poses {
            pose.set(&mut scene, instance).unwrap();
            scene.set_transform(instance, pose.transform).unwrap();
            let after = traced(&scene.commit(), &[instance]);
            let mut fresh = Scene::new();
            let alone = fresh.add(&asset);
            fresh.set_posing(alone, Posing::Recomputed).unwrap();
            pose.set(&mut fresh, alone).unwrap();
            fresh.set_transform(alone, pose.transform).unwrap();
            assert_eq!(traced(&fresh.commit(), &[alone]), after, "{}: {pose:?}", path.display());
            outside += after.1.clusters_outside;
            if after.1.clusters_outside > 0 {
                assert!(after.1.largest_excess > 0.0);
            }
        }
        let skinned = asset.model().pose_spaces.iter().any(|space| space.envelope_count > 1);
        assert_eq!(outside > 0, skinned, "{}", path.display());
    }
}
