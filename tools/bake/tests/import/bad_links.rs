//! Node graphs that are no forest, and links that lead nowhere.

use crate::gltf_builder::Gltf;
use serde_json::json;

#[test]
fn a_node_cycle_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.push("nodes", json!({ "children": [2] }));
    gltf.push("nodes", json!({ "children": [1] }));
    gltf.refused(&["/nodes/1"]);
    gltf.json["nodes"][0]["children"] = json!([0]);
    gltf.refused(&["/nodes/0", "/nodes/1"]);
}

#[test]
fn a_cycle_among_the_joints_of_a_skin_is_refused() {
    let mut gltf = Gltf::skinned();
    gltf.json["nodes"][2]["children"] = json!([1]);
    gltf.refused(&["/nodes/1"]);
}

#[test]
fn a_node_with_two_parents_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.push("nodes", json!({ "children": [0] }));
    gltf.push("nodes", json!({ "children": [0] }));
    let messages = gltf.refused(&["/nodes/2/children/0"]);
    assert_eq!(messages, ["node 0 is already a child of node 1; expected one parent"]);
    gltf.json["nodes"][2]["children"] = json!([]);
    gltf.json["nodes"][1]["children"] = json!([0, 0]);
    gltf.refused(&["/nodes/1/children/1"]);
}

#[test]
fn links_that_lead_nowhere_are_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["scenes"] = json!([{ "nodes": [0, 9] }]);
    gltf.refused(&["/scenes/0/nodes/1"]);
    gltf.json["scene"] = json!(1);
    gltf.refused(&["/scene"]);
    let mut gltf = Gltf::triangle();
    gltf.push("nodes", json!({ "mesh": 9, "skin": 9 }));
    gltf.refused(&["/nodes/1/mesh", "/nodes/1/skin"]);
}
