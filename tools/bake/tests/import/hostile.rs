//! Small files that ask for much.

use crate::gltf_builder::{Gltf, errors};
use restpose_bake::import::import_gltf_bytes;
use serde_json::json;
use std::fmt::Write;

#[test]
fn a_count_without_data_does_not_allocate() {
    let at = "/accessors/0";
    for count in [10_000_000u64, u64::from(u32::MAX), 1 << 53, u64::MAX] {
        let mut gltf = Gltf::triangle();
        gltf.json["accessors"][0] = json!({ "count": count, "componentType": 5126, "type": "VEC3" });
        gltf.refused(&[at]);
        gltf.json["accessors"][0]["bufferView"] = json!(0);
        gltf.refused(&[at]);
    }
}

#[test]
fn one_accessor_decoded_without_end_is_refused() {
    let mut gltf = Gltf::triangle();
    let values = vec![0.0; 30_000];
    let position = gltf.f32s("VEC3", &values);
    let primitive = json!({ "attributes": { "POSITION": position } });
    gltf.json["meshes"][0]["primitives"] = json!(vec![primitive; 3000]);
    // 3,000 times 120 KB would be decoded from a file of 240 KB; the limit is 1,024 times that and 64 MiB.
    assert!(gltf.errors()[0].message.contains("memory limit"));
}

#[test]
fn targets_without_data_are_limited() {
    let mut gltf = Gltf::triangle();
    let position = gltf.f32s("VEC3", &vec![0.0; 30_000]);
    let targets = vec![json!({}); 20_000];
    *gltf.primitive() = json!({ "attributes": { "POSITION": position }, "targets": targets });
    assert!(gltf.errors()[0].message.contains("memory limit"));
}

#[test]
fn a_mesh_with_many_targets_under_many_nodes_is_limited() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["targets"] = json!(vec![json!({}); 8_000]);
    gltf.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 8_000]);
    assert!(gltf.errors()[0].message.contains("memory limit"));
}

#[test]
fn a_chain_of_a_million_nodes_is_imported() {
    const COUNT: usize = 1_000_000;
    let gltf = Gltf::triangle();
    let mut nodes = String::from(r#"{"mesh":0,"children":[1]}"#);
    for node in 1..COUNT - 1 {
        write!(nodes, r#",{{"children":[{}]}}"#, node + 1).unwrap();
    }
    nodes.push_str(",{}");
    let text = gltf.json_text(Some("a.bin")).replace(r#"{"mesh":0}"#, &nodes);
    let load = |_: &str| Ok(gltf.bin.clone());
    let animation = import_gltf_bytes("x.gltf", text.as_bytes(), &load).unwrap().animation;
    assert_eq!(animation.nodes.len(), COUNT);
    assert_eq!(animation.nodes[COUNT - 1].parent, Some(COUNT - 2));
    // Closed to a ring, it is refused.
    let ring = text.replace(",{}", r#",{"children":[0]}"#);
    let result = import_gltf_bytes("x.gltf", ring.as_bytes(), &load);
    assert_eq!(errors(result)[0].path, "/nodes/0");
}

#[test]
fn faults_without_end_are_counted() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"] = json!(vec![json!({ "mesh": 5 }); 5000]);
    let errors = gltf.errors();
    assert_eq!(errors.len(), 1001);
    assert!(errors[1000].message.starts_with("4000 further"));
}
