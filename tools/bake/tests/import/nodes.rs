//! The node graph, scenes and parts.

use crate::gltf_builder::Gltf;
use restpose_bake::import::Local;
use serde_json::json;

fn local(node: serde_json::Value) -> Local {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0] = node;
    gltf.json["nodes"][0]["mesh"] = json!(0);
    gltf.clean().nodes[0].local
}

#[test]
fn transforms_default_to_the_identity() {
    let expected = Local::Trs {
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    assert_eq!(local(json!({})), expected);
}

#[test]
fn translation_rotation_and_scale() {
    let node = json!({ "translation": [1, 2, 3], "rotation": [0.6, 0, 0, -0.8], "scale": [4, 5, 6] });
    let expected = Local::Trs {
        translation: [1.0, 2.0, 3.0],
        rotation: [0.6, 0.0, 0.0, -0.8],
        scale: [4.0, 5.0, 6.0],
    };
    assert_eq!(local(node), expected);
}

#[test]
fn negative_and_zero_scale() {
    let Local::Trs { scale, .. } = local(json!({ "scale": [-1, 0, 2] })) else {
        panic!()
    };
    assert_eq!(scale, [-1.0, 0.0, 2.0]);
}

#[test]
fn matrices_are_column_major() {
    let matrix = json!({ "matrix": [1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 1] });
    let columns = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [10.0, 11.0, 12.0]];
    assert_eq!(local(matrix), Local::Matrix(columns));
}

#[test]
fn a_matrix_that_is_not_affine_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1]);
    gltf.refused(&["/nodes/0/matrix"]);
    gltf.json["nodes"][0]["matrix"] = json!([1, 0, 0]);
    gltf.refused(&["/nodes/0/matrix"]);
}

#[test]
fn a_matrix_goes_before_translation_rotation_and_scale() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    gltf.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    let animation = gltf.warned(&["/nodes/0/matrix"]);
    assert!(matches!(animation.nodes[0].local, Local::Matrix(_)));
}

#[test]
fn rotations_off_unit_length_are_normalised() {
    let Local::Trs { rotation, .. } = local(json!({ "rotation": [0, 0, 0.706, 0.706] })) else {
        panic!()
    };
    assert_eq!(rotation, [0.0, 0.0, 0.5f32.sqrt(), 0.5f32.sqrt()]);
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["rotation"] = json!([0, 0, 3, 4]);
    let animation = gltf.warned(&["/nodes/0/rotation"]);
    let Local::Trs { rotation, .. } = animation.nodes[0].local else {
        panic!()
    };
    assert_eq!(rotation, [0.0, 0.0, 0.6, 0.8]);
    gltf.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    gltf.refused(&["/nodes/0/rotation"]);
}

#[test]
fn the_matrix_of_an_animated_node_is_taken_apart() {
    let mut gltf = Gltf::animated("translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0; 6]);
    // A quarter turn about z after scaling by 2, 3, 4, then a translation.
    gltf.json["nodes"][0]["matrix"] = json!([0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1]);
    let animation = gltf.warned(&["/nodes/0/matrix"]);
    let half = 0.5f32.sqrt();
    let expected = Local::Trs {
        translation: [5.0, 6.0, 7.0],
        rotation: [0.0, 0.0, half, half],
        scale: [2.0, 3.0, 4.0],
    };
    assert_eq!(animation.nodes[0].local, expected);
    gltf.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    assert!(gltf.refused(&["/nodes/0/matrix"])[0].starts_with("the matrix is sheared"));
}

#[test]
fn parents() {
    let mut gltf = Gltf::triangle();
    gltf.push("nodes", json!({ "children": [0, 2] }));
    gltf.push("nodes", json!({}));
    let parents: Vec<_> = gltf.clean().nodes.iter().map(|node| node.parent).collect();
    assert_eq!(parents, [Some(1), None, Some(1)]);
}

/// Nodes 0 to 3 show mesh 0; 1 is a child of 0.
fn four_nodes() -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["children"] = json!([1]);
    for _ in 1..4 {
        gltf.push("nodes", json!({ "mesh": 0 }));
    }
    gltf
}

fn shown(gltf: &Gltf) -> Vec<usize> {
    gltf.clean().parts.iter().map(|part| part.node).collect()
}

#[test]
fn only_the_default_scene_is_shown() {
    let mut gltf = four_nodes();
    gltf.json["scenes"] = json!([{ "nodes": [3] }, { "nodes": [2, 0] }]);
    gltf.json["scene"] = json!(1);
    assert_eq!(shown(&gltf), [0, 1, 2]);
}

#[test]
fn without_a_default_the_first_scene_is_shown() {
    let mut gltf = four_nodes();
    gltf.json["scenes"] = json!([{ "nodes": [3] }, { "nodes": [2, 0] }]);
    assert_eq!(shown(&gltf), [3]);
}

#[test]
fn without_scenes_all_nodes_are_shown() {
    assert_eq!(shown(&four_nodes()), [0, 1, 2, 3]);
}

#[test]
fn a_scene_may_name_a_node_below_the_root() {
    let mut gltf = four_nodes();
    gltf.json["scenes"] = json!([{ "nodes": [1] }]);
    let animation = gltf.warned(&["/scenes/0/nodes/0"]);
    assert_eq!(animation.parts.iter().map(|part| part.node).collect::<Vec<_>>(), [1]);
    assert_eq!(animation.nodes[1].parent, Some(0));
}

#[test]
fn joints_may_lie_outside_the_scene() {
    let mut gltf = Gltf::skinned();
    gltf.json["scenes"] = json!([{ "nodes": [0] }]);
    assert_eq!(gltf.clean().parts[0].skin, Some(0));
}

#[test]
fn parts_are_named_after_node_mesh_or_number() {
    let mut gltf = Gltf::triangle();
    gltf.push(
        "meshes",
        json!({ "name": "body", "primitives": [{ "attributes": { "POSITION": 0 } }] }),
    );
    gltf.push("nodes", json!({ "mesh": 1 }));
    gltf.push("nodes", json!({ "mesh": 1, "name": "hero" }));
    let names: Vec<_> = gltf.clean().parts.into_iter().map(|part| part.name).collect();
    assert_eq!(names, ["node 0", "body", "hero"]);
}

#[test]
fn a_mesh_without_triangles_is_not_shown() {
    let mut gltf = Gltf::triangle();
    gltf.push(
        "meshes",
        json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 1 }] }),
    );
    gltf.push("nodes", json!({ "mesh": 1 }));
    let animation = gltf.warned(&["/meshes/1/primitives/0/mode", "/nodes/1/mesh"]);
    assert_eq!(animation.parts.len(), 1);
    assert_eq!(animation.meshes.len(), 2);
}
