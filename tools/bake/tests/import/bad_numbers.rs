//! Numbers that are not finite, or too large.

use crate::gltf_builder::Gltf;
use restpose_bake::import::MAX_MAGNITUDE;
use serde_json::json;

/// Each with what makes it unusable.
const BAD: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e30, -f32::MAX];

fn refuses_bad_floats(gltf: &Gltf, accessor: usize, place: usize, path: &str) {
    for value in BAD {
        let mut gltf = gltf.clone();
        gltf.set_f32(accessor, place, value);
        let messages = gltf.refused(&[path]);
        assert!(messages[0].contains(&format!("accessor {accessor}")), "{messages:?}");
    }
}

#[test]
fn positions() {
    refuses_bad_floats(&Gltf::triangle(), 0, 4, "/meshes/0/primitives/0/attributes/POSITION");
    let mut gltf = Gltf::triangle();
    gltf.set_f32(0, 4, -MAX_MAGNITUDE);
    gltf.clean();
}

#[test]
fn weights() {
    refuses_bad_floats(&Gltf::skinned(), 2, 0, "/meshes/0/primitives/0/attributes/WEIGHTS_0");
}

#[test]
fn inverse_bind_matrices() {
    let mut gltf = Gltf::skinned();
    let matrices = gltf.f32s(
        "MAT4",
        &[
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]
        .repeat(2),
    );
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    gltf.clean();
    refuses_bad_floats(&gltf, matrices, 17, "/skins/0/inverseBindMatrices");
}

#[test]
fn morph_targets() {
    let mut gltf = Gltf::triangle();
    let target = gltf.f32s("VEC3", &[0.0; 9]);
    gltf.primitive()["targets"] = json!([{ "POSITION": target }]);
    refuses_bad_floats(&gltf, target, 8, "/meshes/0/primitives/0/targets/0/POSITION");
}

#[test]
fn key_times_and_values() {
    let gltf = Gltf::animated("scale", "LINEAR", &[0.0, 1.0], "VEC3", &[1.0; 6]);
    gltf.clean();
    refuses_bad_floats(&gltf, 1, 1, "/animations/0/samplers/0/input");
    refuses_bad_floats(&gltf, 2, 3, "/animations/0/samplers/0/output");
}

#[test]
fn node_transforms() {
    for (key, width) in [("translation", 3), ("scale", 3), ("rotation", 4), ("matrix", 16)] {
        let mut values = vec![0.0; width];
        values[width - 1] = 1.0;
        values[0] = 1e31;
        let mut gltf = Gltf::triangle();
        gltf.json["nodes"][0][key] = json!(values);
        assert_eq!(gltf.errors()[0].path, format!("/nodes/0/{key}/0"));
    }
}

#[test]
fn default_morph_weights() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["targets"] = json!([{}]);
    gltf.json["meshes"][0]["weights"] = json!([1e300]);
    gltf.json["nodes"][0]["weights"] = json!([-1e300]);
    gltf.refused(&["/meshes/0/weights/0", "/nodes/0/weights/0"]);
}

#[test]
fn faults_of_all_stages_are_reported_together() {
    let mut gltf = Gltf::animated("scale", "LINEAR", &[0.0, f32::NAN], "VEC3", &[1.0; 6]);
    gltf.set_f32(0, 0, f32::NAN);
    gltf.json["nodes"][0]["children"] = json!([7]);
    gltf.push("skins", json!({ "joints": [8] }));
    gltf.json["scene"] = json!(0);
    gltf.refused(&[
        "/nodes/0/children/0",
        "/meshes/0/primitives/0/attributes/POSITION",
        "/skins/0/joints/0",
        "/animations/0/samplers/0/input",
        "/scene",
    ]);
}
