//! Animations.

use crate::gltf_builder::{BYTE, Gltf, SHORT, UNSIGNED_BYTE, UNSIGNED_SHORT};
use restpose_bake::import::{Channel, ChannelTarget};
use restpose_formats::rows::Interpolation;
use serde_json::json;

const INPUT: &str = "/animations/0/samplers/0/input";
const OUTPUT: &str = "/animations/0/samplers/0/output";

fn only_channel(gltf: &Gltf) -> Channel {
    let animation = gltf.clean();
    assert_eq!(animation.clips[0].channels.len(), 1);
    animation.clips[0].channels[0].clone()
}

#[test]
fn node_only_animation_of_every_path() {
    for (path, target, shape, width) in [
        ("translation", ChannelTarget::Translation, "VEC3", 3),
        ("rotation", ChannelTarget::Rotation, "VEC4", 4),
        ("scale", ChannelTarget::Scale, "VEC3", 3),
    ] {
        let values: Vec<f32> = [vec![0.0; width - 1], vec![1.0]].concat().repeat(2);
        let channel = only_channel(&Gltf::animated(path, "LINEAR", &[0.5, 1.5], shape, &values));
        let expected = Channel {
            node: 0,
            target,
            interpolation: Interpolation::Linear,
            times: vec![0.5, 1.5],
            values,
        };
        assert_eq!(channel, expected);
    }
}

#[test]
fn step_linear_and_cubic_interpolation() {
    for (name, interpolation) in [
        ("STEP", Interpolation::Step),
        ("LINEAR", Interpolation::Linear),
        ("CUBICSPLINE", Interpolation::CubicSpline),
    ] {
        let values: Vec<f32> = (0..6 * interpolation.values_per_key())
            .map(|value| value as f32)
            .collect();
        let channel = only_channel(&Gltf::animated("scale", name, &[0.0, 1.0], "VEC3", &values));
        assert_eq!((channel.interpolation, channel.values), (interpolation, values));
    }
    let mut gltf = Gltf::animated("scale", "BEZIER", &[0.0, 1.0], "VEC3", &[0.0; 6]);
    gltf.refused(&["/animations/0/samplers/0/interpolation"]);
    gltf.json["animations"][0]["samplers"][0]
        .as_object_mut()
        .unwrap()
        .remove("interpolation");
    assert_eq!(only_channel(&gltf).interpolation, Interpolation::Linear);
}

#[test]
fn normalised_rotations() {
    let cases: [(u32, Vec<u8>, [f32; 4]); 4] = [
        (BYTE, vec![0, 0, 0x81, 0], [0.0, 0.0, -1.0, 0.0]),
        (UNSIGNED_BYTE, vec![0, 255, 0, 0], [0.0, 1.0, 0.0, 0.0]),
        (SHORT, vec![0, 0, 0, 0, 0, 0, 1, 0x80], [0.0, 0.0, 0.0, -1.0]),
        (UNSIGNED_SHORT, vec![0xFF, 0xFF, 0, 0, 0, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]),
    ];
    for (component, bytes, expected) in cases {
        let mut gltf = Gltf::animated("rotation", "STEP", &[0.0], "VEC4", &[0.0; 4]);
        let output = gltf.normalized(component, "VEC4", 1, &bytes);
        gltf.json["animations"][0]["samplers"][0]["output"] = json!(output);
        assert_eq!(only_channel(&gltf).values, expected);
        gltf.json["accessors"][output]["normalized"] = json!(false);
        assert_eq!(gltf.warned(&[OUTPUT]).clips[0].channels[0].values, expected);
    }
}

/// The triangle with two morph targets, their weights moved.
fn weighted(interpolation: &str, times: &[f32], values: &[f32]) -> Gltf {
    let mut gltf = Gltf::animated("weights", interpolation, times, "SCALAR", values);
    let target = gltf.f32s("VEC3", &[1.0; 9]);
    gltf.primitive()["targets"] = json!([{ "POSITION": target }, { "POSITION": target }]);
    gltf
}

#[test]
fn morph_weights() {
    let channel = only_channel(&weighted("LINEAR", &[0.0, 1.0], &[0.0, 1.0, 2.0, 3.0]));
    assert_eq!((channel.target, channel.values.len()), (ChannelTarget::Weights, 4));
    let channel = only_channel(&weighted("CUBICSPLINE", &[0.0], &[0.0; 6]));
    assert_eq!(channel.values.len(), 6);
    let mut gltf = weighted("STEP", &[0.0], &[0.0; 2]);
    let output = gltf.normalized(UNSIGNED_BYTE, "SCALAR", 2, &[255, 51]);
    gltf.json["animations"][0]["samplers"][0]["output"] = json!(output);
    assert_eq!(only_channel(&gltf).values, [1.0, 0.2]);
}

#[test]
fn values_that_do_not_fit_the_keys_are_refused() {
    weighted("LINEAR", &[0.0, 1.0], &[0.0; 3]).refused(&[OUTPUT]);
    weighted("LINEAR", &[0.0, 1.0], &[0.0; 6]).refused(&[OUTPUT]);
    Gltf::animated("scale", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0; 3]).refused(&[OUTPUT]);
    Gltf::animated("scale", "CUBICSPLINE", &[0.0, 1.0], "VEC3", &[0.0; 6]).refused(&[OUTPUT]);
    Gltf::animated("scale", "LINEAR", &[0.0, 1.0], "VEC4", &[0.0; 8]).refused(&[OUTPUT]);
}

#[test]
fn channels_that_move_nothing_are_ignored_with_a_warning() {
    let target = "/animations/0/channels/0/target";
    let mut gltf = Gltf::animated("scale", "LINEAR", &[0.0], "VEC3", &[0.0; 3]);
    gltf.json["animations"][0]["channels"][0]["target"] = json!({ "path": "scale" });
    assert!(gltf.warned(&[target]).clips[0].channels.is_empty());
    gltf.json["animations"][0]["channels"][0]["target"] = json!({ "path": "pointer", "node": 0 });
    gltf.warned(&["/animations/0/channels/0/target/path"]);
    gltf.json["animations"][0]["channels"][0]["target"] = json!({ "path": "weights", "node": 0 });
    gltf.warned(&[target]);
    Gltf::animated("scale", "LINEAR", &[], "VEC3", &[]).warned(&["/animations/0/channels/0"]);
}

#[test]
fn of_two_channels_for_one_property_the_first_counts() {
    let mut gltf = Gltf::animated("scale", "LINEAR", &[0.0], "VEC3", &[7.0; 3]);
    let other = gltf.f32s("VEC3", &[8.0; 3]);
    let mut sampler = gltf.json["animations"][0]["samplers"][0].clone();
    sampler["output"] = json!(other);
    gltf.json["animations"][0]["samplers"]
        .as_array_mut()
        .unwrap()
        .push(sampler);
    let channel = json!({ "sampler": 1, "target": { "node": 0, "path": "scale" } });
    gltf.json["animations"][0]["channels"]
        .as_array_mut()
        .unwrap()
        .push(channel);
    let animation = gltf.warned(&["/animations/0/channels/1/target"]);
    assert_eq!(animation.clips[0].channels.len(), 1);
    assert_eq!(animation.clips[0].channels[0].values, [7.0; 3]);
}

#[test]
fn keys_at_one_time_become_a_jump() {
    let values: Vec<f32> = (0..12).map(|value| value as f32).collect();
    let animation = Gltf::animated("scale", "LINEAR", &[0.0, 1.0, 1.0, 2.0], "VEC3", &values).warned(&[INPUT]);
    let channel = &animation.clips[0].channels[0];
    assert_eq!(channel.times, [0.0, 1.0f32.next_down(), 1.0, 2.0]);
    assert_eq!(channel.values, values);
}

#[test]
fn decreasing_key_times_are_refused() {
    Gltf::animated("scale", "LINEAR", &[0.0, 2.0, 1.0], "VEC3", &[0.0; 9]).refused(&[INPUT]);
}

#[test]
fn a_key_before_zero_is_kept_with_a_warning() {
    let gltf = Gltf::animated("scale", "LINEAR", &[-1.0, 2.0], "VEC3", &[0.0; 6]);
    assert_eq!(gltf.warned(&[INPUT]).clips[0].channels[0].times, [-1.0, 2.0]);
}

#[test]
fn rotations_without_direction_are_refused_but_tangents_may_vanish() {
    let unit = [0.0, 0.0, 0.0, 1.0];
    Gltf::animated("rotation", "LINEAR", &[0.0, 1.0], "VEC4", &[unit, [0.0; 4]].concat()).refused(&[OUTPUT]);
    // Its squared length is no normal number in the runtime's arithmetic.
    Gltf::animated("rotation", "LINEAR", &[0.0, 1.0], "VEC4", &[unit, [1e-20; 4]].concat()).refused(&[OUTPUT]);
    Gltf::animated(
        "rotation",
        "CUBICSPLINE",
        &[0.0],
        "VEC4",
        &[[0.0; 4], unit, [0.0; 4]].concat(),
    )
    .clean();
    Gltf::animated(
        "rotation",
        "CUBICSPLINE",
        &[0.0],
        "VEC4",
        &[unit, [0.0; 4], unit].concat(),
    )
    .refused(&[OUTPUT]);
}

#[test]
fn rotations_far_from_unit_length_are_kept_with_a_warning() {
    let gltf = Gltf::animated("rotation", "LINEAR", &[0.0], "VEC4", &[0.0, 0.0, 3.0, 4.0]);
    assert_eq!(gltf.warned(&[OUTPUT]).clips[0].channels[0].values, [0.0, 0.0, 3.0, 4.0]);
}

#[test]
fn several_clips_keep_their_numbers_and_names() {
    let mut gltf = Gltf::animated("scale", "LINEAR", &[0.0], "VEC3", &[7.0; 3]);
    gltf.json["animations"]
        .as_array_mut()
        .unwrap()
        .insert(0, json!({ "name": "idle", "channels": [], "samplers": [] }));
    let animation = gltf.clean();
    assert_eq!(
        animation
            .clips
            .iter()
            .map(|clip| clip.name.as_str())
            .collect::<Vec<_>>(),
        ["idle", ""]
    );
    assert_eq!(animation.clips[1].channels.len(), 1);
}

#[test]
fn channels_that_point_nowhere_are_refused() {
    let mut gltf = Gltf::animated("scale", "LINEAR", &[0.0], "VEC3", &[7.0; 3]);
    let channel = |node: u32, sampler: u32| json!({ "sampler": sampler, "target": { "node": node, "path": "scale" } });
    gltf.json["animations"][0]["channels"] = json!([channel(9, 0), channel(0, 9)]);
    gltf.refused(&[
        "/animations/0/channels/0/target/node",
        "/animations/0/channels/1/sampler",
    ]);
    gltf.json["animations"][0]["channels"] = json!([channel(0, 0)]);
    gltf.json["animations"][0]["samplers"][0]["input"] = json!(9);
    gltf.refused(&[INPUT]);
}
