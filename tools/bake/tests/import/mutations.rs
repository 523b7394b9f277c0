//! Whatever is changed in a file, an import ends with errors or keeps its guarantee.

use crate::{
    gltf_builder::{BYTE, Gltf, UNSIGNED_BYTE},
    guarantee::check,
};
use serde_json::{Value, json};

/// A file that uses most of what is read: skin, sparse and quantised morph targets, strip, matrix node, three clips.
fn rich() -> Gltf {
    let mut gltf = Gltf::skinned();
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 4, &[0, 1, 2, 1]);
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["mode"] = json!(5);
    let target = gltf.normalized(BYTE, "VEC3", 3, &[1; 9]);
    let (places, values) = (gltf.view(&[2]), gltf.view(&[0x81; 3]));
    gltf.json["accessors"][target]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": places, "byteOffset": 0, "componentType": UNSIGNED_BYTE },
        "values": { "bufferView": values, "byteOffset": 0 },
    });
    gltf.primitive()["targets"] = json!([{ "POSITION": target }]);
    gltf.json["meshes"][0]["weights"] = json!([0.5]);
    gltf.json["nodes"][0]["weights"] = json!([0.25]);
    gltf.json["nodes"][2]["rotation"] = json!([0, 0, 0, 1]);
    gltf.json["nodes"][2]["scale"] = json!([1, 2, 3]);
    gltf.push(
        "nodes",
        json!({ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "name": "n" }),
    );
    let matrix = [
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let matrices = gltf.f32s("MAT4", &matrix.repeat(2));
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    gltf.json["skins"][0]["skeleton"] = json!(1);
    let times = gltf.f32s("SCALAR", &[0.0, 1.0]);
    let outputs = [
        (
            1,
            "rotation",
            "LINEAR",
            gltf.f32s("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]),
        ),
        (2, "translation", "CUBICSPLINE", gltf.f32s("VEC3", &[1.0; 18])),
        (0, "weights", "STEP", gltf.f32s("SCALAR", &[0.0, 1.0])),
    ];
    for (node, path, interpolation, output) in outputs {
        gltf.push(
            "animations",
            json!({
                "name": path,
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
                "samplers": [{ "input": times, "output": output, "interpolation": interpolation }],
            }),
        );
    }
    gltf.json["scenes"] = json!([{ "nodes": [0, 1, 3] }]);
    gltf.json["scene"] = json!(0);
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() }]);
    gltf
}

/// JSON pointers to every value below `value`.
fn pointers(value: &Value, at: &str, out: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(list) => list
            .iter()
            .enumerate()
            .map(|(place, value)| (place.to_string(), value))
            .collect(),
        _ => Vec::new(),
    };
    for (key, child) in children {
        let path = format!("{at}/{key}");
        pointers(child, &path, out);
        out.push(path);
    }
}

#[test]
fn every_value_of_the_json_replaced() {
    let gltf = rich();
    gltf.clean();
    let mut paths = Vec::new();
    pointers(&gltf.json, "", &mut paths);
    assert!(paths.len() > 200, "{}", paths.len());
    let others = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(0.5),
        json!(1e31),
        json!(5121),
        json!(5126),
        json!(4_294_967_295u64),
        json!(u64::MAX),
        json!("x"),
        json!("MAT4"),
        json!([]),
        json!([0]),
        json!([0, 0, 0, 0]),
        json!({}),
    ];
    for path in &paths {
        for other in &others {
            let mut gltf = gltf.clone();
            *gltf.json.pointer_mut(path).unwrap() = other.clone();
            check(gltf.import(), &format!("{path} = {other}"));
        }
    }
}

#[test]
fn every_value_of_the_json_removed() {
    let gltf = rich();
    let mut paths = Vec::new();
    pointers(&gltf.json, "", &mut paths);
    for path in &paths {
        let mut gltf = gltf.clone();
        let (parent, key) = path.rsplit_once('/').unwrap();
        match gltf.json.pointer_mut(parent).unwrap() {
            Value::Object(map) => drop(map.remove(key)),
            Value::Array(list) => drop(list.remove(key.parse().unwrap())),
            other => panic!("{other}"),
        }
        check(gltf.import(), &format!("without {path}"));
    }
}

#[test]
fn every_byte_of_the_buffer_replaced() {
    let gltf = rich();
    for place in 0..gltf.bin.len() {
        for byte in [0, 1, 0x7F, 0x80, 0xFF] {
            let mut gltf = gltf.clone();
            gltf.bin[place] = byte;
            check(gltf.import(), &format!("byte {place} = {byte}"));
        }
    }
}
