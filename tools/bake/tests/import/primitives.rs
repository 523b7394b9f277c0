//! Meshes, primitives and their triangles.

use crate::gltf_builder::{Gltf, UNSIGNED_BYTE};
use serde_json::json;

/// A primitive of five vertices in this mode.
fn five(mode: u32) -> Gltf {
    let mut gltf = Gltf::triangle();
    let values: Vec<f32> = (0..15).map(|value| value as f32).collect();
    let position = gltf.f32s("VEC3", &values);
    *gltf.primitive() = json!({ "attributes": { "POSITION": position }, "mode": mode });
    gltf
}

#[test]
fn triangle_strips() {
    let animation = five(5).clean();
    assert_eq!(
        animation.meshes[0].primitives[0].triangles,
        [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    );
}

#[test]
fn triangle_fans() {
    let animation = five(6).clean();
    assert_eq!(
        animation.meshes[0].primitives[0].triangles,
        [[1, 2, 0], [2, 3, 0], [3, 4, 0]]
    );
}

#[test]
fn indexed_strips() {
    let mut gltf = five(5);
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 4, &[4, 2, 0, 1]);
    gltf.primitive()["indices"] = json!(indices);
    assert_eq!(gltf.clean().meshes[0].primitives[0].triangles, [[4, 2, 0], [2, 1, 0]]);
}

#[test]
fn vertices_left_over_are_ignored_with_a_warning() {
    let animation = five(4).warned(&["/meshes/0/primitives/0/attributes/POSITION"]);
    assert_eq!(animation.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
}

#[test]
fn points_and_lines_are_skipped_with_a_warning() {
    for mode in 0..4 {
        let mut gltf = Gltf::triangle();
        let primitives = gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        let mut points = primitives[0].clone();
        points["mode"] = json!(mode);
        primitives.insert(0, points);
        let animation = gltf.warned(&["/meshes/0/primitives/0/mode"]);
        assert_eq!(animation.meshes[0].primitives.len(), 1);
        assert_eq!(animation.meshes[0].primitives[0].source_primitive, 1);
    }
    five(7).refused(&["/meshes/0/primitives/0/mode"]);
}

#[test]
fn primitives_without_positions_or_triangles_are_skipped_with_a_warning() {
    let mut gltf = Gltf::triangle();
    let two = gltf.f32s("VEC3", &[0.0; 6]);
    let primitives = gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": {} }));
    primitives.push(json!({ "attributes": { "POSITION": two } }));
    let animation = gltf.warned(&[
        "/meshes/0/primitives/1/attributes",
        "/meshes/0/primitives/2/attributes/POSITION",
        "/meshes/0/primitives/2",
    ]);
    assert_eq!(animation.meshes[0].primitives.len(), 1);
}

#[test]
fn several_primitives_in_a_mesh() {
    let mut gltf = Gltf::triangle();
    let position = gltf.f32s("VEC3", &[5.0; 9]);
    gltf.json["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "attributes": { "POSITION": position } }));
    let animation = gltf.clean();
    let numbers: Vec<_> = animation.meshes[0]
        .primitives
        .iter()
        .map(|primitive| primitive.source_primitive)
        .collect();
    assert_eq!(numbers, [0, 1]);
    assert_eq!(animation.meshes[0].primitives[1].positions, [[5.0; 3]; 3]);
}

#[test]
fn zero_area_triangles_are_kept() {
    let mut gltf = Gltf::triangle();
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 6, &[0, 0, 1, 0, 1, 2]);
    gltf.primitive()["indices"] = json!(indices);
    assert_eq!(gltf.clean().meshes[0].primitives[0].triangles, [[0, 0, 1], [0, 1, 2]]);
}

#[test]
fn an_index_out_of_range_is_refused() {
    let mut gltf = Gltf::triangle();
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 3, &[0, 1, 3]);
    gltf.primitive()["indices"] = json!(indices);
    let messages = gltf.refused(&["/meshes/0/primitives/0/indices"]);
    assert_eq!(messages, ["index 2 is 3; the primitive has 3 vertices"]);
}

#[test]
fn a_restart_index_that_is_a_vertex_is_kept_with_a_warning() {
    let mut gltf = Gltf::triangle();
    let position = gltf.f32s("VEC3", &[0.0; 768]);
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 3, &[0, 1, 255]);
    *gltf.primitive() = json!({ "attributes": { "POSITION": position }, "indices": indices });
    let animation = gltf.warned(&["/meshes/0/primitives/0/indices"]);
    assert_eq!(animation.meshes[0].primitives[0].triangles, [[0, 1, 255]]);
}

#[test]
fn a_file_without_triangles_is_refused() {
    Gltf::empty().refused(&[""]);
    five(0).refused(&[""]);
    let mut gltf = Gltf::triangle();
    gltf.json["scenes"] = json!([{}]);
    gltf.refused(&[""]);
}
