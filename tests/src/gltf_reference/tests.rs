//! The reference against answers worked out by hand.

use super::Reference;
use super::document::{Document, base64, unrolled};
use serde_json::{Value, json};
use std::path::Path;

/// A few roundings of f64 numbers of a few units.
const ROUNDING: f64 = 1e-14;

impl Document {
    fn new(json: Value) -> Document {
        let mut json = json;
        json["buffers"] = json!([{ "byteLength": 0 }]);
        json["bufferViews"] = json!([]);
        json["accessors"] = json!([]);
        Document {
            json,
            buffers: vec![Vec::new()],
        }
    }

    fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.buffers[0].len();
        self.buffers[0].extend_from_slice(bytes);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }),
        )
    }

    fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = values.len() / width;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }),
        )
    }

    fn bytes(&mut self, kind: &str, width: usize, values: &[u8]) -> usize {
        let view = self.view(values);
        let count = values.len() / width;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5121, "count": count, "type": kind }),
        )
    }

    /// A clip of one channel on one node.
    fn set_clip(&mut self, node: usize, path: &str, interpolation: &str, times: &[f32], values: (&str, usize, &[f32])) {
        let input = self.floats("SCALAR", 1, times);
        let output = self.floats(values.0, values.1, values.2);
        self.json["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        }]);
    }
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    let near = found
        .iter()
        .zip(expected)
        .all(|(found, expected)| (found - expected).abs() < ROUNDING);
    assert!(near, "{found:?} instead of {expected:?}");
}

/// One node with one vertex at (1, 0, 0).
fn one_vertex() -> Document {
    let mut document = Document::new(json!({
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    }));
    document.floats("VEC3", 3, &[1.0, 0.0, 0.0]);
    document
}

/// Node 0 shows one vertex at (2, 0, 0) under a skin of node 1, which stands at (1, 0, 0), and node 2, at the origin.
/// The node with the mesh is moved far away, which must not matter.
fn skinned(weights: [f32; 4]) -> Document {
    let mut document = Document::new(json!({
        "nodes": [
            { "mesh": 0, "skin": 0, "translation": [50, 60, 70] },
            { "translation": [1, 0, 0] },
            {},
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 } }] }],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": 3 }],
    }));
    document.floats("VEC3", 3, &[2.0, 0.0, 0.0]);
    document.bytes("VEC4", 4, &[0, 1, 0, 0]);
    document.floats("VEC4", 4, &weights);
    let mut matrices = [0.0; 32];
    for diagonal in [0, 5, 10, 15, 16, 21, 26, 31] {
        matrices[diagonal] = 1.0;
    }
    matrices[12] = -1.0;
    document.floats("MAT4", 16, &matrices);
    document
}

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

#[test]
fn a_skin_at_rest_leaves_the_vertex_where_it_is() {
    let reference = skinned([0.5, 0.5, 0.0, 0.0]).decode();
    close(reference.positions(0, None, 0.0)[0][0], [2.0, 0.0, 0.0]);
}

#[test]
fn one_joint_turned_by_a_quarter() {
    let mut document = skinned([1.0, 0.0, 0.0, 0.0]);
    document.set_clip(1, "rotation", "LINEAR", &[0.0], ("VEC4", 4, &[0.0, 0.0, HALF, HALF]));
    let reference = document.decode();
    // (2, 0, 0) lies (1, 0, 0) from the joint, and comes to lie (0, 1, 0) from it.
    close(reference.positions(0, Some(0), 0.0)[0][0], [1.0, 1.0, 0.0]);
}

#[test]
fn two_joints_share_a_vertex_whatever_their_weights_sum_to() {
    for weights in [[0.5, 0.5, 0.0, 0.0], [0.25, 0.25, 0.0, 0.0]] {
        let mut document = skinned(weights);
        document.set_clip(2, "translation", "LINEAR", &[0.0], ("VEC3", 3, &[0.0, 2.0, 4.0]));
        close(document.decode().positions(0, Some(0), 0.0)[0][0], [2.0, 1.0, 2.0]);
    }
}

#[test]
fn slerp_moves_evenly_on_the_arc_and_the_shorter_way() {
    for sign in [1.0, -1.0] {
        let mut document = one_vertex();
        let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * HALF, sign * HALF];
        document.set_clip(0, "rotation", "LINEAR", &[1.0, 4.0], ("VEC4", 4, &keys));
        let reference = document.decode();
        let half = 0.5_f64.sqrt();
        close(reference.positions(0, Some(0), 2.5)[0][0], [half, half, 0.0]);
        close(reference.positions(0, Some(0), 2.0)[0][0], [0.75_f64.sqrt(), 0.5, 0.0]);
        close(reference.positions(0, Some(0), 9.0)[0][0], [0.0, 1.0, 0.0]);
    }
}

#[test]
fn cubic_spline_between_its_keys_and_beyond() {
    let mut document = one_vertex();
    // Per key: in-tangent, value, out-tangent.
    #[rustfmt::skip]
    let keys = [
        9.0, 9.0, 9.0,  0.0, 0.0, 0.0,  1.0, 0.0, 2.0,
        -1.0, 0.0, 2.0,  4.0, 0.0, 0.0,  9.0, 9.0, 9.0,
    ];
    document.set_clip(0, "translation", "CUBICSPLINE", &[0.0, 2.0], ("VEC3", 3, &keys));
    let reference = document.decode();
    // x: 0/2 + 2·1/8 + 4/2 - 2·(-1)/8; z: the tangents cancel. The vertex itself is at x = 1.
    close(reference.positions(0, Some(0), 1.0)[0][0], [1.0 + 2.5, 0.0, 0.0]);
    // At a quarter: h01 = 5/32, h10 = 9/64, h11 = -3/64.
    let x = 4.0 * 5.0 / 32.0 + 2.0 * 9.0 / 64.0 + 2.0 * 3.0 / 64.0;
    let z = 2.0 * 2.0 * (9.0 - 3.0) / 64.0;
    close(reference.positions(0, Some(0), 0.5)[0][0], [1.0 + x, 0.0, z]);
    close(reference.positions(0, Some(0), -1.0)[0][0], [1.0, 0.0, 0.0]);
    close(reference.positions(0, Some(0), 3.0)[0][0], [5.0, 0.0, 0.0]);
    assert_eq!(reference.clip_time_range(0), (0.0, 2.0));
}

#[test]
fn cubic_spline_rotations_are_made_unit() {
    let mut document = one_vertex();
    let mut keys = [0.0; 24];
    keys[7] = 1.0;
    keys[18] = 1.0;
    document.set_clip(0, "rotation", "CUBICSPLINE", &[0.0, 1.0], ("VEC4", 4, &keys));
    // Half-way between no turn and half a turn about z the spline is (0, 0, 1/2, 1/2): a quarter.
    close(document.decode().positions(0, Some(0), 0.5)[0][0], [0.0, 1.0, 0.0]);
}

#[test]
fn steps_hold_until_the_next_key() {
    let mut document = one_vertex();
    let keys = [1.0, 1.0, 1.0, 5.0, 1.0, 1.0];
    document.set_clip(0, "scale", "STEP", &[1.0, 2.0], ("VEC3", 3, &keys));
    let reference = document.decode();
    for (seconds, x) in [(0.0, 1.0), (1.0, 1.0), (1.999, 1.0), (2.0, 5.0), (7.0, 5.0)] {
        close(reference.positions(0, Some(0), seconds)[0][0], [x, 0.0, 0.0]);
    }
}

#[test]
fn morph_comes_before_skin() {
    let mut document = skinned([0.0, 1.0, 0.0, 0.0]);
    let target = document.floats("VEC3", 3, &[0.0, 3.0, 0.0]);
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{ "POSITION": target }, { "NORMAL": target }]);
    document.json["meshes"][0]["weights"] = json!([1.0, 1.0]);
    document.json["nodes"][2]["scale"] = json!([2, 2, 2]);
    // Of the mesh, of the node instead, of a clip instead; then twice as large by the joint.
    close(document.decode().positions(0, None, 0.0)[0][0], [4.0, 6.0, 0.0]);
    document.json["nodes"][0]["weights"] = json!([0.5, 0.0]);
    close(document.decode().positions(0, None, 0.0)[0][0], [4.0, 3.0, 0.0]);
    document.set_clip(
        0,
        "weights",
        "LINEAR",
        &[0.0, 1.0],
        ("SCALAR", 1, &[0.0, 0.0, 1.0, 8.0]),
    );
    close(document.decode().positions(0, Some(0), 0.25)[0][0], [4.0, 1.5, 0.0]);
}

#[test]
fn transforms_stack_from_the_root() {
    let mut document = one_vertex();
    // Column-major: x goes to y, y to -x, then 10 along z.
    document.json["nodes"] = json!([
        { "mesh": 0, "translation": [1, 0, 0], "scale": [-3, 1, 1] },
        { "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 10, 1], "children": [0] },
    ]);
    // (1, 0, 0) is mirrored to (-3, 0, 0), moved to (-2, 0, 0), turned to (0, -2, 0), moved to (0, -2, 10).
    close(document.decode().positions(0, None, 0.0)[0][0], [0.0, -2.0, 10.0]);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    let order = [7, 8, 9, 4, 5];
    assert_eq!(unrolled(4, &order[..4]), [[7, 8, 9]]);
    assert_eq!(unrolled(5, &order), [[7, 8, 9], [8, 4, 9], [9, 4, 5]]);
    assert_eq!(unrolled(6, &order), [[8, 9, 7], [9, 4, 7], [4, 5, 7]]);
    assert!(unrolled(1, &order).is_empty());
}

#[test]
fn accessors_may_be_strided_normalised_and_sparse() {
    let mut document = Document::new(json!({}));
    let view = document.view(&[9, 9, 0x81, 127, 9, 9, 0x80, 0, 9, 9, 1, 2]);
    document.json["bufferViews"][view]["byteStride"] = json!(4);
    let places = document.view(&[1]);
    let values = document.view(&[0xff, 1]);
    let accessor = json!({
        "bufferView": view, "byteOffset": 2, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC2",
    });
    let plain = document.push("accessors", accessor.clone());
    let mut accessor = accessor;
    accessor["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": places, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let sparse = document.push("accessors", accessor);
    let last = [1.0 / 127.0, 2.0 / 127.0];
    // -128 and -127 both stand for -1.
    assert_eq!(document.rows(plain), [[-1.0, 1.0], [-1.0, 0.0], last]);
    assert_eq!(document.rows(sparse), [[-1.0, 1.0], [-1.0 / 127.0, 1.0 / 127.0], last]);
}

#[test]
fn parts_are_the_nodes_of_the_default_scene_in_ascending_order() {
    let mut document = one_vertex();
    document.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0 }, { "children": [1] }, { "mesh": 0 }]);
    document.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [3, 2] }]);
    document.json["scene"] = json!(1);
    let nodes = |document: &Document| -> Vec<usize> {
        let reference = document.decode();
        reference.parts().iter().map(|part| part.node).collect()
    };
    assert_eq!(nodes(&document), [1, 3]);
    document.json["scene"] = Value::Null;
    assert_eq!(nodes(&document), [0]);
}

#[test]
fn base64_of_every_length() {
    for (text, bytes) in [
        ("", &b""[..]),
        ("Zg==", b"f"),
        ("Zm8=", b"fo"),
        ("Zm9v", b"foo"),
        ("Zm9vYg==", b"foob"),
    ] {
        assert_eq!(base64(text), bytes);
    }
    assert_eq!(base64("+/8="), [0xfb, 0xff]);
}

#[test]
fn every_form_of_file_is_read() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    for (name, parts) in [
        ("walker.glb", 2),
        ("tentacle.gltf", 2),
        ("machine.gltf", 23),
        ("mixed.glb", 6),
    ] {
        let reference = Reference::load(&scenes.join(name));
        assert_eq!(reference.parts().len(), parts, "{name}");
        assert_eq!(reference.clip_count(), 2, "{name}");
        let (_, end) = reference.clip_time_range(0);
        for part in 0..parts {
            let positions = reference.positions(part, Some(0), end * 0.4).concat();
            assert!(
                positions.iter().flatten().all(|value| value.abs() < 5.0),
                "{name} part {part}"
            );
        }
    }
}
