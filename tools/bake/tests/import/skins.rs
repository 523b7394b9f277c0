//! Skins, joints and weights.

use crate::gltf_builder::{Gltf, UNSIGNED_BYTE, UNSIGNED_SHORT};
use restpose_bake::import::Influence;
use serde_json::json;

const JOINTS: &str = "/meshes/0/primitives/0/attributes/JOINTS_0";
const WEIGHTS: &str = "/meshes/0/primitives/0/attributes/WEIGHTS_0";

fn influences(gltf: &Gltf) -> Vec<Vec<(usize, f32)>> {
    let animation = gltf.clean();
    let pairs = |list: &Vec<Influence>| {
        list.iter()
            .map(|influence| (influence.joint, influence.weight))
            .collect()
    };
    animation.meshes[0].primitives[0].influences.iter().map(pairs).collect()
}

#[test]
fn joints_and_weights() {
    let gltf = Gltf::skinned();
    assert_eq!(
        influences(&gltf),
        [vec![(0, 1.0)], vec![(1, 1.0)], vec![(0, 0.5), (1, 0.5)]]
    );
    let animation = gltf.clean();
    assert_eq!(animation.skins[0].joints, [1, 2]);
    assert_eq!(animation.parts[0].skin, Some(0));
}

#[test]
fn joints_of_16_bits() {
    let mut gltf = Gltf::skinned();
    let joints = gltf.u16s("VEC4", &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    gltf.attributes()["JOINTS_0"] = json!(joints);
    assert_eq!(influences(&gltf), influences(&Gltf::skinned()));
}

#[test]
fn normalised_weights() {
    let mut gltf = Gltf::skinned();
    let bytes = [255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0];
    let weights = gltf.normalized(UNSIGNED_BYTE, "VEC4", 3, &bytes);
    gltf.attributes()["WEIGHTS_0"] = json!(weights);
    assert_eq!(influences(&gltf)[2], [(0, 0.2), (1, 0.8)]);
    let words: Vec<u8> = bytes.iter().flat_map(|byte| [*byte, *byte]).collect();
    let weights = gltf.normalized(UNSIGNED_SHORT, "VEC4", 3, &words);
    gltf.attributes()["WEIGHTS_0"] = json!(weights);
    assert_eq!(influences(&gltf)[2], [(0, 0.2), (1, 0.8)]);
    gltf.json["accessors"][weights]["normalized"] = json!(false);
    let animation = gltf.warned(&[WEIGHTS]);
    assert_eq!(animation.meshes[0].primitives[0].influences[2][0].weight, 0.2);
}

#[test]
fn any_number_of_sets() {
    let mut gltf = Gltf::skinned();
    for set in 1..12 {
        let joints = gltf.accessor(UNSIGNED_BYTE, "VEC4", 3, &[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        // Each set adds a sixteenth to joint 1 of vertex 0.
        let weights = gltf.f32s("VEC4", &[0.0, 0.0625, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        gltf.attributes()[format!("JOINTS_{set}")] = json!(joints);
        gltf.attributes()[format!("WEIGHTS_{set}")] = json!(weights);
    }
    gltf.set_f32(2, 0, 0.3125);
    assert_eq!(influences(&gltf)[0], [(0, 0.3125), (1, 0.6875)]);
    // The twelfth set counts as the first does: nothing stops at nine.
    let last = gltf.attributes()["JOINTS_11"].as_u64().unwrap() as usize;
    gltf.data_of(last)[1] = 9;
    gltf.refused(&["/meshes/0/primitives/0/attributes/JOINTS_11"]);
}

#[test]
fn a_joint_listed_twice_on_a_vertex_is_merged() {
    let mut gltf = Gltf::skinned();
    gltf.data_of(1)[8..12].copy_from_slice(&[1, 1, 0, 0]);
    assert_eq!(influences(&gltf)[2], [(1, 1.0)]);
}

#[test]
fn a_joint_without_weight_may_be_any_number() {
    let mut gltf = Gltf::skinned();
    gltf.data_of(1)[1] = 200;
    assert_eq!(influences(&gltf)[0], [(0, 1.0)]);
}

#[test]
fn a_joint_out_of_range_is_refused() {
    let mut gltf = Gltf::skinned();
    gltf.data_of(1)[9] = 2;
    let messages = gltf.refused(&[JOINTS]);
    assert_eq!(messages, ["vertex 2 refers to joint 2; the skin over it has 2 joints"]);
}

#[test]
fn negative_and_vanishing_weights_are_refused() {
    let mut gltf = Gltf::skinned();
    gltf.set_f32(2, 8, -0.5);
    assert!(gltf.refused(&[WEIGHTS])[0].contains("vertex 2"));
    gltf.set_f32(2, 8, 0.0);
    gltf.set_f32(2, 9, 0.0);
    assert!(gltf.refused(&[WEIGHTS])[0].contains("vertex 2 sum to zero"));
}

#[test]
fn weights_that_do_not_sum_to_one_are_kept_with_a_warning() {
    let mut gltf = Gltf::skinned();
    gltf.set_f32(2, 0, 4.0);
    let animation = gltf.warned(&[WEIGHTS]);
    assert_eq!(
        animation.meshes[0].primitives[0].influences[0],
        [Influence { joint: 0, weight: 4.0 }]
    );
}

#[test]
fn missing_inverse_bind_matrices_are_identities() {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];
    assert_eq!(Gltf::skinned().clean().skins[0].inverse_bind, [identity; 2]);
}

/// Sixteen numbers, column by column: columns 1 2 3, 4 5 6, 7 8 9 and the translation 10 11 12.
const MATRIX: [f32; 16] = [
    1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 0.0, 7.0, 8.0, 9.0, 0.0, 10.0, 11.0, 12.0, 1.0,
];

#[test]
fn inverse_bind_matrices_are_column_major() {
    let mut gltf = Gltf::skinned();
    // One matrix more than there are joints: allowed.
    let matrices = gltf.f32s("MAT4", &MATRIX.repeat(3));
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    let columns = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [10.0, 11.0, 12.0]];
    assert_eq!(gltf.clean().skins[0].inverse_bind, [columns; 2]);
}

#[test]
fn broken_inverse_bind_matrices_are_refused() {
    let at = "/skins/0/inverseBindMatrices";
    let mut gltf = Gltf::skinned();
    let matrices = gltf.f32s("MAT4", &MATRIX);
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    assert!(gltf.refused(&[at])[0].starts_with("1 matrices for 2 joints"));
    let matrices = gltf.f32s("MAT4", &MATRIX.repeat(2));
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    gltf.set_f32(matrices, 31, 1.000_1);
    gltf.warned(&[at]);
    gltf.set_f32(matrices, 31, 0.0);
    gltf.refused(&[at]);
    gltf.set_f32(matrices, 31, f32::NAN);
    gltf.refused(&[at]);
}

#[test]
fn one_mesh_under_several_skins_and_nodes() {
    let mut gltf = Gltf::skinned();
    gltf.push("skins", json!({ "joints": [2, 1, 0] }));
    gltf.push("nodes", json!({ "mesh": 0, "skin": 1, "name": "other" }));
    gltf.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    let animation = gltf.clean();
    let parts: Vec<_> = animation
        .parts
        .iter()
        .map(|part| (part.node, part.mesh, part.skin))
        .collect();
    assert_eq!(parts, [(0, 0, Some(0)), (3, 0, Some(1)), (4, 0, Some(0))]);
    assert_eq!(animation.parts[1].name, "other");
    // Every skin over the mesh must have the joint.
    gltf.json["skins"][1]["joints"] = json!([2]);
    assert!(gltf.refused(&[JOINTS])[0].contains("has 1 joints"));
}

#[test]
fn a_skin_over_a_mesh_without_joints_is_ignored_with_a_warning() {
    let mut gltf = Gltf::skinned();
    *gltf.attributes() = json!({ "POSITION": 0 });
    let animation = gltf.warned(&["/nodes/0/skin"]);
    assert_eq!(animation.parts[0].skin, None);
}

#[test]
fn joints_without_a_skin_are_ignored_with_a_warning() {
    let mut gltf = Gltf::skinned();
    gltf.json["nodes"][0] = json!({ "mesh": 0 });
    // Nothing of them is looked at.
    gltf.data_of(1)[0] = 77;
    let animation = gltf.warned(&[JOINTS]);
    assert_eq!(animation.parts[0].skin, None);
    assert_eq!(
        animation.meshes[0].primitives[0].influences,
        Vec::<Vec<Influence>>::new()
    );
}

#[test]
fn the_same_mesh_with_and_without_skin() {
    let mut gltf = Gltf::skinned();
    gltf.push("nodes", json!({ "mesh": 0 }));
    let animation = gltf.clean();
    assert_eq!(
        animation.parts.iter().map(|part| part.skin).collect::<Vec<_>>(),
        [Some(0), None]
    );
}

#[test]
fn a_mesh_only_partly_skinned_is_refused() {
    let mut gltf = Gltf::skinned();
    gltf.json["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "attributes": { "POSITION": 0 } }));
    assert!(gltf.refused(&["/nodes/0/skin"])[0].starts_with("primitive 1 "));
}

#[test]
fn joints_and_weights_come_in_pairs_of_the_right_length() {
    let mut gltf = Gltf::skinned();
    gltf.attributes().as_object_mut().unwrap().remove("WEIGHTS_0");
    gltf.refused(&[JOINTS]);
    let mut gltf = Gltf::skinned();
    gltf.attributes().as_object_mut().unwrap().remove("JOINTS_0");
    gltf.refused(&[WEIGHTS]);
    let mut gltf = Gltf::skinned();
    gltf.json["accessors"][1]["count"] = json!(2);
    gltf.refused(&[JOINTS]);
    let mut gltf = Gltf::skinned();
    gltf.json["accessors"][2]["count"] = json!(2);
    gltf.refused(&[WEIGHTS]);
}

#[test]
fn joints_and_skeletons_that_point_nowhere_are_refused() {
    let mut gltf = Gltf::skinned();
    gltf.json["skins"][0] = json!({ "joints": [1, 3, 2, 9], "skeleton": 3 });
    gltf.refused(&["/skins/0/joints/1", "/skins/0/joints/3", "/skins/0/skeleton"]);
    gltf.json["skins"][0] = json!({ "joints": [] });
    assert!(gltf.errors().iter().any(|fault| fault.path == "/skins/0/joints"));
    gltf.json["nodes"][0]["skin"] = json!(1);
    assert!(gltf.errors().iter().any(|fault| fault.path == "/nodes/0/skin"));
}

#[test]
fn a_joint_listed_twice_in_a_skin_is_kept_with_a_warning() {
    let mut gltf = Gltf::skinned();
    gltf.json["skins"][0] = json!({ "joints": [1, 1] });
    assert_eq!(gltf.warned(&["/skins/0/joints/1"]).skins[0].joints, [1, 1]);
}
