//! Poses as a caller gives them: refused ones change nothing, extreme ones are traced.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    verify::{Oracle, Rays},
};
use restpose_runtime::{Affine, Asset, Frame, InstanceId, PoseError, Ray, Scene};
use restpose_tests::{Recipe, baked_asset, random_animation, sample_scenes};
use std::sync::Arc;

fn walker() -> Arc<Asset> {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    baked_asset(&path).1
}

#[test]
fn refused_poses_are_named_and_change_nothing() {
    let asset = walker();
    let mut scene = Scene::new();
    let walker = scene.add(&asset);
    let palette = scene.pose(walker).unwrap().palette;
    let bones = palette.len();

    let short = scene.set_palette(walker, &palette[1..], &[]);
    assert_eq!(
        short,
        Err(PoseError::PaletteLength {
            expected: bones,
            found: bones - 1
        })
    );
    let weights = scene.set_palette(walker, &palette, &[0.5]);
    assert_eq!(weights, Err(PoseError::MorphWeightsLength { expected: 0, found: 1 }));
    let mut broken = palette.clone();
    broken[3].columns[1][2] = f32::NAN;
    let name = asset.model().meta.bone_names[3].clone();
    assert_eq!(
        scene.set_palette(walker, &broken, &[]),
        Err(PoseError::BoneNotFinite { bone: 3, name })
    );
    let count = asset.model().clips.len();
    assert_eq!(
        scene.play(walker, count, 0.0),
        Err(PoseError::UnknownClip { clip: count, count })
    );
    assert!(matches!(
        scene.play(walker, 0, f32::NAN),
        Err(PoseError::TimeNotFinite { .. })
    ));
    let infinite = Affine::from_translation([f32::INFINITY, 0.0, 0.0]);
    assert_eq!(
        scene.set_transform(walker, infinite),
        Err(PoseError::TransformNotFinite)
    );
    assert_eq!(scene.pose(walker).unwrap().palette, palette);

    let other = Scene::new();
    assert_eq!(
        other.pose(walker).map(|pose| pose.palette),
        Err(PoseError::UnknownInstance { instance: 0, count: 0 })
    );
}

#[test]
fn an_empty_scene_is_hit_by_nothing() {
    let mut scene = Scene::new();
    let frame = scene.commit();
    assert_eq!(frame.closest_hit(&Ray::new([0.0; 3], [1.0, 0.0, 0.0])), None);
    assert!(frame.bounds().is_empty());
}

fn assert_equals_brute_force(frame: &Frame, instance: InstanceId, seed: u64) -> usize {
    let oracle = Oracle::new(frame, &[instance]);
    let mut hits = 0;
    for ray in Rays::new(&oracle, seed).take(1_000) {
        let expected = oracle.closest_hit(&ray);
        assert_eq!(frame.closest_hit(&ray), expected, "{ray:?}");
        assert_eq!(frame.any_hit(&ray), expected.is_some(), "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    hits
}

/// Instance transforms do not leave the pose space, however they stretch it.
#[test]
fn extreme_transforms_equal_brute_force() {
    let asset = walker();
    let sample = asset.model().samples[40];
    let diagonal = |x: f32, y: f32, z: f32| Affine {
        columns: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [0.0; 3]],
    };
    let mut sheared = Affine::IDENTITY;
    sheared.columns[1] = [0.9, 1.0, -3.0];
    let mut nearly_flat = diagonal(1.0, 1.0, 1.0);
    nearly_flat.columns[2] = [1.0, 1.0, 1e-6];
    for (name, transform, hit) in [
        ("far away", Affine::from_translation([1e7, -1e7, 1e7]), true),
        ("tiny", diagonal(1e-25, 1e-25, 1e-25), true),
        ("huge", diagonal(1e25, 1e25, 1e25), true),
        ("mirrored", diagonal(-1.0, 1.0, 1.0), true),
        ("uneven", diagonal(1e-3, 1.0, 1e3), true),
        ("sheared", sheared, true),
        ("nearly flat", nearly_flat, true),
        ("flat", diagonal(1.0, 0.0, 1.0), true),
        ("a point", diagonal(0.0, 0.0, 0.0), false),
    ] {
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_transform(instance, transform).unwrap();
        scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        let hits = assert_equals_brute_force(&scene.commit(), instance, 21);
        assert_eq!(hits > 0, hit, "{name}");
    }
}

/// Bones scaled to nothing, mirrored and stretched by clips: clusters without a usable inverse are traced, and counted.
#[test]
fn vanishing_bones_equal_brute_force() {
    let recipe = Recipe {
        seed: 5,
        vertices: 80,
        joints: 6,
        scale: 1.0,
        offset: 0.0,
        wild_scales: true,
        morph_targets: 1,
    };
    let animation = random_animation(&recipe);
    let settings = BakeSettings {
        sample_step_seconds: 0.125,
        ..BakeSettings::default()
    };
    let baked = bake(&animation, &settings, &NoProgress).unwrap();
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap());
    let mut without_inverse = 0;
    for sample in asset.model().samples.iter().skip(1) {
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        let frame = scene.commit();
        frame.prepare();
        without_inverse += frame.stats().clusters_without_inverse;
        assert_equals_brute_force(&frame, instance, 22);
    }
    assert!(without_inverse > 0, "the recipe makes some");
}

/// Every posed vertex of a cluster lies in its world box, with no tolerance.
#[test]
fn world_boxes_contain_their_vertices() {
    let asset = walker();
    let model = asset.model();
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    scene
        .set_transform(instance, Affine::from_translation([1e4, 3.0, -1e5]))
        .unwrap();
    for sample in model.samples.iter().skip(1).step_by(9) {
        scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        let frame = scene.commit();
        for bounds in frame.clusters() {
            let row = &model.clusters[bounds.cluster as usize];
            for triangle in &model.references[row.reference_first as usize..][..row.reference_count as usize] {
                for vertex in frame.triangle(instance, *triangle).unwrap() {
                    assert!(bounds.bounds_world.contains(vertex), "{vertex:?} is outside {bounds:?}");
                }
            }
        }
    }
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let asset = walker();
    let mut scene = Scene::new();
    scene.add(&asset);
    let frame = scene.commit();
    let center = frame.bounds().center();
    let good = Ray::new([center[0], center[1], center[2] + 9.0], [0.0, 0.0, -1.0]);
    assert!(frame.closest_hit(&good).is_some());
    for bad in [
        Ray {
            origin: [f32::NAN, 0.0, 0.0],
            ..good
        },
        Ray {
            origin: [0.0, f32::INFINITY, 0.0],
            ..good
        },
        Ray {
            direction: [0.0; 3],
            ..good
        },
        Ray {
            direction: [0.0, f32::NAN, 1.0],
            ..good
        },
        Ray {
            direction: [0.0, f32::NEG_INFINITY, 1.0],
            ..good
        },
        Ray {
            t_min: 3.0,
            t_max: 2.0,
            ..good
        },
        Ray {
            t_min: f32::NAN,
            ..good
        },
        Ray {
            t_max: f32::NAN,
            ..good
        },
        Ray {
            t_min: f32::INFINITY,
            ..good
        },
    ] {
        assert_eq!(frame.closest_hit(&bad), None, "{bad:?}");
        assert!(!frame.any_hit(&bad), "{bad:?}");
    }
}
