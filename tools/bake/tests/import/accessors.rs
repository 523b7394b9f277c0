//! How numbers stand in buffers.

use crate::gltf_builder::{BYTE, Gltf, SHORT, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT};
use restpose_bake::import::Primitive;
use serde_json::json;

fn only_primitive(gltf: &Gltf) -> Primitive {
    gltf.clean().meshes[0].primitives[0].clone()
}

#[test]
fn indices_of_8_16_and_32_bits() {
    let kinds: [(u32, Vec<u8>); 3] = [
        (UNSIGNED_BYTE, vec![2, 1, 0]),
        (UNSIGNED_SHORT, vec![2, 0, 1, 0, 0, 0]),
        (UNSIGNED_INT, vec![2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]),
    ];
    for (component, bytes) in kinds {
        let mut gltf = Gltf::triangle();
        let indices = gltf.accessor(component, "SCALAR", 3, &bytes);
        gltf.primitive()["indices"] = json!(indices);
        assert_eq!(only_primitive(&gltf).triangles, [[2, 1, 0]]);
    }
}

#[test]
fn interleaved_strides_and_offsets() {
    let mut gltf = Gltf::triangle();
    let mut bytes = vec![0xFF; 5];
    for vertex in 0..3u8 {
        bytes.extend(
            [f32::from(vertex), 10.0 + f32::from(vertex), 0.5]
                .iter()
                .flat_map(|value| value.to_le_bytes()),
        );
        if vertex < 2 {
            bytes.extend([0xFF; 7]);
        }
    }
    let number = gltf.accessor(5126, "VEC3", 3, &bytes);
    gltf.json["accessors"][number]["byteOffset"] = json!(5);
    gltf.json["bufferViews"][number]["byteStride"] = json!(19);
    gltf.attributes()["POSITION"] = json!(number);
    assert_eq!(
        only_primitive(&gltf).positions,
        [[0.0, 10.0, 0.5], [1.0, 11.0, 0.5], [2.0, 12.0, 0.5]]
    );
    // One more byte of offset, and the last element passes the end.
    gltf.json["accessors"][number]["byteOffset"] = json!(6);
    gltf.refused(&[&format!("/accessors/{number}")]);
}

#[test]
fn a_stride_of_zero_means_tightly_packed() {
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["byteStride"] = json!(0);
    gltf.clean();
}

#[test]
fn a_stride_below_the_element_size_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["byteStride"] = json!(8);
    gltf.refused(&["/bufferViews/0/byteStride"]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut gltf = Gltf::triangle();
    for (component, bytes) in [
        (UNSIGNED_BYTE, vec![0, 2]),
        (UNSIGNED_SHORT, vec![0, 0, 2, 0]),
        (UNSIGNED_INT, vec![0, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let indices = gltf.view(&bytes);
        let values: Vec<u8> = [7.0f32, 8.0, 9.0, 4.0, 5.0, 6.0]
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let values = gltf.view(&values);
        gltf.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": component },
            "values": { "bufferView": values },
        });
        assert_eq!(
            only_primitive(&gltf).positions,
            [[7.0, 8.0, 9.0], [1.0, 0.0, 0.0], [4.0, 5.0, 6.0]]
        );
    }
}

#[test]
fn sparse_accessors_without_buffer_view_start_from_zeros() {
    let mut gltf = Gltf::triangle();
    let (indices, values) = (
        gltf.view(&[1]),
        gltf.view(&[0, 0, 128, 63, 0, 0, 128, 63, 0, 0, 128, 63]),
    );
    gltf.json["accessors"][0] = json!({
        "count": 3, "componentType": 5126, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": { "bufferView": indices, "componentType": UNSIGNED_BYTE },
            "values": { "bufferView": values },
        },
    });
    assert_eq!(only_primitive(&gltf).positions, [[0.0; 3], [1.0; 3], [0.0; 3]]);
}

#[test]
fn broken_sparse_accessors_are_refused() {
    let mut gltf = Gltf::triangle();
    let (indices, values) = (gltf.view(&[3]), gltf.view(&[0; 12]));
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": UNSIGNED_BYTE },
        "values": { "bufferView": values },
    });
    gltf.json["accessors"][0]["sparse"] = sparse.clone();
    gltf.refused(&["/accessors/0/sparse/indices"]);
    gltf.json["accessors"][0]["sparse"]["count"] = json!(2);
    gltf.refused(&["/accessors/0/sparse/indices"]);
    gltf.json["accessors"][0]["sparse"]["indices"]["componentType"] = json!(BYTE);
    gltf.refused(&["/accessors/0/sparse/indices/componentType"]);
    gltf.json["accessors"][0]["sparse"] = sparse.clone();
    gltf.json["accessors"][0]["sparse"]["values"]["byteOffset"] = json!(4);
    gltf.refused(&["/accessors/0/sparse/values"]);
    gltf.json["accessors"][0]["sparse"]["values"]["bufferView"] = json!(99);
    gltf.refused(&["/accessors/0/sparse/values/bufferView"]);
}

/// Component type, bytes of a vertex, and its position when not normalised and when normalised.
type Case = (u32, &'static [u8], [[f32; 3]; 2]);

#[test]
fn quantised_positions_of_every_kind() {
    let cases: [Case; 4] = [
        (BYTE, &[127, 0x80, 1], [[127.0, -128.0, 1.0], [1.0, -1.0, 1.0 / 127.0]]),
        (UNSIGNED_BYTE, &[255, 0, 51], [[255.0, 0.0, 51.0], [1.0, 0.0, 0.2]]),
        (
            SHORT,
            &[0xFF, 0x7F, 0, 0x80, 1, 0],
            [[32767.0, -32768.0, 1.0], [1.0, -1.0, 1.0 / 32767.0]],
        ),
        (
            UNSIGNED_SHORT,
            &[0xFF, 0xFF, 0, 0, 1, 0],
            [[65535.0, 0.0, 1.0], [1.0, 0.0, 1.0 / 65535.0]],
        ),
    ];
    for (component, vertex, [whole, normalized]) in cases {
        let mut gltf = Gltf::triangle();
        gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let number = gltf.accessor(component, "VEC3", 3, &vertex.repeat(3));
        gltf.attributes()["POSITION"] = json!(number);
        assert_eq!(only_primitive(&gltf).positions, [whole; 3]);
        gltf.json["accessors"][number]["normalized"] = json!(true);
        assert_eq!(only_primitive(&gltf).positions, [normalized; 3]);
    }
}

#[test]
fn quantised_positions_without_the_extension_are_decoded_with_a_warning() {
    let mut gltf = Gltf::triangle();
    let number = gltf.accessor(BYTE, "VEC3", 3, &[1; 9]);
    gltf.attributes()["POSITION"] = json!(number);
    gltf.warned(&["/extensionsUsed"]);
}

#[test]
fn an_accessor_past_its_buffer_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["count"] = json!(4);
    gltf.refused(&["/accessors/0"]);
    gltf.json["accessors"][0]["byteOffset"] = json!(u64::MAX);
    gltf.refused(&["/accessors/0"]);
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["byteLength"] = json!(gltf.bin.len() + 1);
    gltf.refused(&["/bufferViews/0"]);
    gltf.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
    gltf.refused(&["/bufferViews/0"]);
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["buffer"] = json!(9);
    gltf.refused(&["/buffers/9"]);
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["bufferView"] = json!(9);
    gltf.refused(&["/accessors/0/bufferView"]);
}

#[test]
fn accessors_of_the_wrong_kind_are_refused() {
    let at = "/meshes/0/primitives/0/attributes/POSITION";
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["type"] = json!("VEC4");
    assert_eq!(gltf.refused(&[at]), ["accessor 0 is a VEC4; expected VEC3"]);
    gltf.json["accessors"][0]["type"] = json!("VEC3");
    gltf.json["accessors"][0]["componentType"] = json!(UNSIGNED_INT);
    gltf.refused(&[at]);
    gltf.json["accessors"][0]["componentType"] = json!(5124);
    gltf.refused(&["/accessors/0/componentType"]);
    gltf.attributes()["POSITION"] = json!(9);
    gltf.refused(&[at]);
}
