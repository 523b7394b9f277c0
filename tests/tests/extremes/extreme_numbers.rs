//! The contract at the ends of the range of `f32`: numbers that overflow or underflow on the way cost time, not hits.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{Animation, Channel, ChannelTarget, Influence, Local},
    verify::Oracle,
};
use restpose_formats::rows::Interpolation;
use restpose_runtime::{Affine, Asset, Frame, InstanceId, Posing, Ray, Scene};
use restpose_tests::{Recipe, random_animation};
use std::sync::Arc;

/// A right triangle of size `unit` at z = `unit`, moved by `joints` joints at the origin with these weights and scales.
fn triangle(unit: f32, joints: usize, weights: &[(usize, f32)]) -> Animation {
    let recipe = Recipe {
        seed: 1,
        vertices: 3,
        joints,
        scale: 1.0,
        offset: 0.0,
        wild_scales: false,
        morph_targets: 0,
    };
    let mut animation = random_animation(&recipe);
    animation.clips[0].channels.clear();
    for node in &mut animation.nodes {
        node.parent = None;
        node.local = scaled(1.0);
    }
    let primitive = &mut animation.meshes[0].primitives[0];
    primitive.positions = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
        .map(|p| p.map(|x| x * unit))
        .to_vec();
    primitive.triangles = vec![[0, 1, 2]];
    let influence = |(joint, weight): &(usize, f32)| Influence {
        joint: *joint,
        weight: *weight,
    };
    primitive.influences = vec![weights.iter().map(influence).collect(); 3];
    animation
}

fn scaled(scale: f32) -> Local {
    Local::Trs {
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [scale; 3],
    }
}

fn baked(animation: &Animation) -> Arc<Asset> {
    let settings = BakeSettings {
        sample_step_seconds: 1.0,
        ..BakeSettings::default()
    };
    let baked = bake(animation, &settings, &NoProgress).unwrap();
    Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap())
}

/// Asserts that the ray hits by brute force, and by the runtime in the same way.
fn assert_hits(frame: &Frame, instance: InstanceId, ray: &Ray) {
    let expected = Oracle::new(frame, &[instance]).closest_hit(ray);
    assert!(expected.is_some(), "the ray is meant to hit: {ray:?}");
    assert_eq!(frame.closest_hit(ray), expected, "{ray:?}");
    assert!(frame.any_hit(ray), "{ray:?}");
}

/// Far from a small instance, the ray's origin has no `f32` in the cluster's local space.
#[test]
fn origins_that_overflow_in_local_space_lose_no_hit() {
    let asset = baked(&triangle(1.0, 1, &[(0, 1.0)]));
    for (scale, distance) in [(1e-15f32, 1e25f32), (1e-10, 1e30), (1e-3, 1e36), (1.0, 1e38)] {
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        let mut transform = Affine::IDENTITY;
        for k in 0..3 {
            transform.columns[k][k] = scale;
        }
        scene.set_transform(instance, transform).unwrap();
        let ray = Ray {
            t_max: 2.0 * distance,
            ..Ray::new([0.25 * scale, 0.25 * scale, -distance], [0.0, 0.0, 1.0])
        };
        assert_hits(&scene.commit(), instance, &ray);
    }
}

/// Two bones take turns at being 2⁸⁰ times as large as the other, so the triangle's fuzzy box ends beyond `f32` in the
/// local space of either.
#[test]
fn fuzzy_boxes_beyond_f32_lose_no_hit() {
    let (unit, large, small) = (1e15f32, 2f32.powi(40), 2f32.powi(-40));
    let mut animation = triangle(unit, 2, &[(0, 0.5), (1, 0.5)]);
    for (node, scales) in [(1, [small, large]), (2, [large, small])] {
        animation.clips[0].channels.push(Channel {
            node,
            target: ChannelTarget::Scale,
            interpolation: Interpolation::Step,
            times: vec![0.0, 1.0],
            values: scales.into_iter().flat_map(|scale| [scale; 3]).collect(),
        });
    }
    let asset = baked(&animation);
    let size = unit * large * 0.5;
    for seconds in [0.0, 1.0] {
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene.play(instance, 0, seconds).unwrap();
        let ray = Ray::new([0.25 * size, 0.25 * size, 0.9999 * size], [0.0, 0.0, 1.0]);
        assert_hits(&scene.commit(), instance, &ray);
    }
}

/// Morph weights times deltas underflow, and bones that the cluster frame does not share enlarge what rounding that
/// was.
#[test]
fn morphs_that_underflow_lose_no_hit() {
    for seed in 0..50u64 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut animation = triangle(1e-44, 3, &[]);
        let weights = [[0.25, 0.75], [0.5, 0.5], [0.875, 0.125]];
        animation.meshes[0].primitives[0].influences = weights
            .iter()
            .map(|pair| {
                (1..3)
                    .zip(pair)
                    .map(|(joint, weight)| Influence { joint, weight: *weight })
                    .collect()
            })
            .collect();
        for joint in [1, 2] {
            let q: [f32; 4] = std::array::from_fn(|_| random.f32() * 2.0 - 1.0);
            let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
            animation.nodes[1 + joint].local = Local::Trs {
                translation: [0.0; 3],
                rotation: q.map(|x| x / length),
                scale: [1e30; 3],
            };
        }
        let deltas = (0..3).map(|_| std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * 1e-20));
        animation.meshes[0].primitives[0].morph_targets = vec![deltas.collect()];
        animation.meshes[0].morph_target_count = 1;
        animation.nodes[0].weights = vec![0.0];
        animation.clips[0].channels.push(Channel {
            node: 0,
            target: ChannelTarget::Weights,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            values: vec![1.37e-22, 2e-22],
        });
        let asset = baked(&animation);
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene.play(instance, 0, 1.0).unwrap();
        let frame = scene.commit();
        let corners = frame.triangle(instance, 0).unwrap();
        let bounds = frame.clusters().next().unwrap().bounds_world;
        for corner in corners {
            assert!(bounds.contains(corner), "seed {seed}: {corner:?} is outside {bounds:?}");
        }
    }
}
