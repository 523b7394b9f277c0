//! Morph targets and their weights.

use crate::gltf_builder::{BYTE, Gltf, UNSIGNED_BYTE};
use serde_json::json;

/// Gives the first primitive two targets.
fn morphed(mut gltf: Gltf) -> Gltf {
    let (a, b) = (gltf.f32s("VEC3", &[1.0; 9]), gltf.f32s("VEC3", &[2.0; 9]));
    gltf.primitive()["targets"] = json!([{ "POSITION": a, "NORMAL": 99 }, { "POSITION": b }]);
    gltf
}

#[test]
fn morph_targets_alone() {
    let animation = morphed(Gltf::triangle()).clean();
    assert_eq!(
        animation.meshes[0].primitives[0].morph_targets,
        [[[1.0; 3]; 3], [[2.0; 3]; 3]]
    );
    assert_eq!(animation.meshes[0].morph_target_count, 2);
    assert_eq!(animation.nodes[0].weights, [0.0, 0.0]);
}

#[test]
fn morph_targets_under_a_skin() {
    let animation = morphed(Gltf::skinned()).clean();
    assert_eq!(animation.meshes[0].primitives[0].morph_targets.len(), 2);
    assert_eq!(animation.parts[0].skin, Some(0));
}

#[test]
fn a_target_without_positions_moves_nothing() {
    let mut gltf = morphed(Gltf::triangle());
    gltf.primitive()["targets"][0] = json!({ "NORMAL": 0 });
    assert_eq!(gltf.clean().meshes[0].primitives[0].morph_targets[0], [[0.0; 3]; 3]);
}

#[test]
fn sparse_and_quantised_targets() {
    let mut gltf = morphed(Gltf::triangle());
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let bytes = gltf.normalized(BYTE, "VEC3", 3, &[127; 9]);
    let (indices, values) = (gltf.view(&[2]), gltf.view(&[0x81; 3]));
    gltf.json["accessors"][bytes]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": UNSIGNED_BYTE },
        "values": { "bufferView": values },
    });
    gltf.primitive()["targets"][0]["POSITION"] = json!(bytes);
    assert_eq!(
        gltf.clean().meshes[0].primitives[0].morph_targets[0],
        [[1.0; 3], [1.0; 3], [-1.0; 3]]
    );
}

#[test]
fn default_weights_are_the_nodes_else_the_meshs_else_zero() {
    let mut gltf = morphed(Gltf::triangle());
    gltf.json["meshes"][0]["weights"] = json!([0.25, 0.5]);
    gltf.push("nodes", json!({ "mesh": 0, "weights": [1, -1] }));
    gltf.push("nodes", json!({}));
    let weights: Vec<_> = gltf.clean().nodes.into_iter().map(|node| node.weights).collect();
    assert_eq!(weights, [vec![0.25, 0.5], vec![1.0, -1.0], vec![]]);
}

#[test]
fn default_weights_of_the_wrong_number_are_adjusted_with_a_warning() {
    let mut gltf = morphed(Gltf::triangle());
    gltf.json["meshes"][0]["weights"] = json!([0.25]);
    gltf.push("nodes", json!({ "mesh": 0, "weights": [1, 2, 3] }));
    let animation = gltf.warned(&["/meshes/0/weights", "/nodes/1/weights"]);
    let weights: Vec<_> = animation.nodes.into_iter().map(|node| node.weights).collect();
    assert_eq!(weights, [[0.25, 0.0], [1.0, 2.0]]);
}

#[test]
fn targets_of_the_wrong_number_or_length_are_refused() {
    let mut gltf = morphed(Gltf::triangle());
    gltf.json["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "attributes": { "POSITION": 0 } }));
    gltf.refused(&["/meshes/0/primitives/1/targets"]);
    let mut gltf = morphed(Gltf::triangle());
    gltf.json["accessors"][1]["count"] = json!(2);
    gltf.refused(&["/meshes/0/primitives/0/targets/0/POSITION"]);
}
