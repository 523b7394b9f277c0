//! Boxes of the stretches of clips hold at every time, whatever moves in between the keys.

mod contains;
mod stretches;

use contains::{assert_contains, used_vertices};
use fastrand::Rng;
use restpose_bake::import::{Animation, Channel, ChannelTarget, Local};
use restpose_formats::{
    Bounds,
    rows::{ClipBoundsRow, Interpolation, STRETCHES},
};
use restpose_runtime::{Aabb, Asset, Scene};
use restpose_tests::{
    MeshRecipe, Recipe, baked_asset, baked_with, jointed_mesh, random_animation, sample_scenes, tube,
};
use std::sync::Arc;

/// Random times per clip, in and about it.
const TIMES: usize = 200;

#[test]
fn samples_stay_in_the_boxes_of_their_clips() {
    for path in sample_scenes() {
        let (_, asset) = baked_asset(&path);
        let name = path.display().to_string();
        let unknown = assert_contains(&name, &asset, TIMES, 7);
        let expected = if asset.model().caches.is_empty() {
            0
        } else {
            asset.model().clips.len() * STRETCHES + 1
        };
        assert_eq!(unknown, expected, "{name}");
    }
}

/// Joints on arcs and on splines, scales in steps through zero and below, weights of morph targets, any unit, any place.
#[test]
fn soups_stay_in_the_boxes_of_their_clips() {
    for seed in 0..60 {
        let mut random = Rng::with_seed(seed);
        let recipe = Recipe {
            seed,
            vertices: random.usize(8..40),
            joints: random.usize(1..8),
            scale: 10f32.powi(random.i32(-9..=9)),
            offset: [0.0, 0.0, 1.0, 1e3][random.usize(..4)],
            wild_scales: seed.is_multiple_of(3),
            morph_targets: random.usize(..4),
        };
        let animation = random_animation(&recipe);
        let asset = baked_with(&animation, &sampled(1.0));
        assert_contains(&format!("{recipe:?}"), &asset, TIMES, seed);
    }
}

fn sampled(sample_step_seconds: f64) -> restpose_bake::BakeSettings {
    restpose_bake::BakeSettings {
        bounds: Bounds::Sampled,
        sample_step_seconds,
        ..Default::default()
    }
}

/// A tube whose joints move as `channel` says, one key at each of 0, 0.5 and 1 s; its asset, bound by samples alone.
fn moved_tube(change: impl FnOnce(&mut Animation)) -> Arc<Asset> {
    let surface = tube();
    let mut animation = jointed_mesh(&MeshRecipe::new(&surface, 4));
    change(&mut animation);
    baked_with(&animation, &sampled(1.0))
}

/// The channel that moves this property of the last joint, in place of what moved it.
fn replace(animation: &mut Animation, target: ChannelTarget, interpolation: Interpolation, values: Vec<f32>) {
    let node = animation.skins[0].joints[1];
    let channels = &mut animation.clips[0].channels;
    channels.retain(|channel| channel.node != node || channel.target != target);
    channels.push(Channel {
        node,
        target,
        interpolation,
        times: vec![0.0, 0.5, 1.0],
        values,
    });
}

/// The farthest that a vertex is along an axis at the clip's keys, and what the boxes of all of its stretches say.
fn at_keys_and_by_box(asset: &Arc<Asset>) -> (Aabb, Aabb) {
    let model = asset.model();
    let bounds = ClipBoundsRow::around_clip(model.clip_bounds, 0).unwrap();
    (union_of_poses(asset, 0, &[0.0, 0.5, 1.0]), bounds)
}

/// The union of posed boxes at times of a clip: of the vertices themselves.
fn union_of_poses(asset: &Arc<Asset>, clip: usize, times: &[f32]) -> Aabb {
    let used = used_vertices(asset);
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    let mut vertices = Vec::new();
    let mut all = Aabb::EMPTY;
    for seconds in times {
        scene.play(instance, clip, *seconds).unwrap();
        let frame = scene.commit();
        frame.vertices(instance, &mut vertices).unwrap();
        all = all.union(Aabb::around(used.iter().map(|vertex| vertices[*vertex])));
    }
    all
}

#[test]
fn splines_that_overshoot_stay_in_the_box() {
    let asset = moved_tube(|animation| {
        let zero = [0.0, 0.0, 0.0];
        let (fast, back) = ([40.0, 0.0, 0.0], [-40.0, 0.0, 0.0]);
        let values = [zero, zero, fast, back, zero, fast, back, zero, zero].concat();
        replace(
            animation,
            ChannelTarget::Translation,
            Interpolation::CubicSpline,
            values,
        );
    });
    assert_eq!(assert_contains("splines", &asset, 2_000, 1), 0);
    let (keys, bounds) = at_keys_and_by_box(&asset);
    // A spline from 0 to 0 with tangents ±40 over half a second is at 40/2·(1/4) = 5 in the middle.
    assert!(bounds.max[0] > keys.max[0] + 4.0, "{keys:?} {bounds:?}");
}

#[test]
fn steps_stay_in_the_box() {
    let asset = moved_tube(|animation| {
        let values = vec![0.0, 0.0, 0.0, 9.0, -5.0, 0.0, 0.0, 0.0, -7.0];
        replace(animation, ChannelTarget::Translation, Interpolation::Step, values);
    });
    assert_eq!(assert_contains("steps", &asset, 2_000, 2), 0);
}

/// Keys half a turn apart, about skew axes: which way the arc goes is decided by the last bit of a dot product, and the
/// baker must decide as the evaluator does.
#[test]
fn arcs_stay_in_the_box() {
    let mut random = Rng::with_seed(11);
    for seed in 0..40 {
        let asset = moved_tube(|animation| {
            let unit = |q: [f32; 4]| {
                let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
                q.map(|x| x / length)
            };
            let [x, y, z, w] = unit(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
            // Each is the one before after a half turn: orthogonal to it but for rounding.
            let values = [[x, y, z, w], [w, z, -y, -x], [-z, w, x, -y]].concat();
            replace(animation, ChannelTarget::Rotation, Interpolation::Linear, values);
        });
        assert_eq!(assert_contains("arcs", &asset, 100, seed), 0);
    }
}

#[test]
fn scales_through_zero_stay_in_the_box() {
    let asset = moved_tube(|animation| {
        let values = vec![3.0, 3.0, 3.0, -2.0, 1.0, 0.0, 1.0, -5.0, 4.0];
        replace(animation, ChannelTarget::Scale, Interpolation::Linear, values);
    });
    assert_eq!(assert_contains("scales", &asset, 2_000, 3), 0);
}

#[test]
fn nodes_with_matrices_stay_in_the_box() {
    let asset = moved_tube(|animation| {
        let root = animation.skins[0].joints[0];
        animation.nodes[root].local =
            Local::Matrix([[0.0, 3.0, 0.5], [-2.0, 0.0, 1.0], [0.3, 0.0, 1.5], [4.0, 5.0, 6.0]]);
        animation.clips[0].channels.retain(|channel| channel.node != root);
    });
    assert_eq!(assert_contains("matrices", &asset, 2_000, 4), 0);
}

/// Weights between 0 and 1 at the keys, far above in between.
#[test]
fn weights_that_overshoot_stay_in_the_box() {
    let recipe = Recipe {
        seed: 5,
        vertices: 20,
        joints: 3,
        scale: 1.0,
        offset: 0.0,
        wild_scales: false,
        morph_targets: 2,
    };
    let mut animation = random_animation(&recipe);
    let weights = |channel: &&mut Channel| channel.target == ChannelTarget::Weights;
    let channel = animation.clips[0].channels.iter_mut().find(weights).unwrap();
    channel.interpolation = Interpolation::CubicSpline;
    channel.values = [[0.0, 0.0], [0.2, 0.1], [90.0, -70.0]].concat().repeat(3);
    let asset = baked_with(&animation, &sampled(1.0));
    assert_eq!(assert_contains("weights", &asset, 2_000, 6), 0);
    let (keys, bounds) = at_keys_and_by_box(&asset);
    assert!(bounds.surface_area() > 2.0 * keys.surface_area(), "{keys:?} {bounds:?}");
}

/// A cubic of quaternions through zero turns at any speed: nothing bounds the stretches in which it does or nearly does, and
/// the instance is bounded by its pose there.
#[test]
fn what_nothing_bounds_is_bounded_by_its_pose() {
    let asset = moved_tube(|animation| {
        let key = |sign: f32| [[0.0; 4], [0.0, 0.6 * sign, 0.0, 0.8 * sign], [0.0; 4]].concat();
        let values = [key(1.0), key(-1.0), key(1.0)].concat();
        replace(animation, ChannelTarget::Rotation, Interpolation::CubicSpline, values);
    });
    // It does so at 0.25 s and 0.75 s, each the border of two stretches.
    assert_eq!(assert_contains("through zero", &asset, 10, 8), 4);
    let used = used_vertices(&asset);
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    let mut vertices = Vec::new();
    for seconds in [0.2, 0.25, 0.26, 0.7] {
        scene.play(instance, 0, seconds).unwrap();
        let frame = scene.commit();
        let bounds = frame.instance_bounds(instance).unwrap();
        frame.vertices(instance, &mut vertices).unwrap();
        assert!(used.iter().all(|vertex| bounds.contains(vertices[*vertex])));
    }
}
