//! Extensions, required and optional.

use crate::gltf_builder::Gltf;
use restpose_bake::import::ImportError;
use serde_json::json;

fn requiring(names: &[&str]) -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!(names);
    gltf.json["extensionsRequired"] = json!(names);
    gltf
}

#[test]
fn extensions_about_looks_are_accepted() {
    requiring(&[
        "KHR_mesh_quantization",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "KHR_lights_punctual",
        "KHR_materials_unlit",
        "KHR_materials_variants",
        "EXT_texture_webp",
        "KHR_xmp_json_ld",
    ])
    .clean();
}

#[test]
fn required_extensions_that_are_not_supported_are_refused_by_name() {
    let names = [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "EXT_mesh_gpu_instancing",
        "VENDOR_unheard_of",
    ];
    for name in names {
        let error = requiring(&["KHR_materials_unlit", name]).import().unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
        assert!(matches!(error, ImportError::UnsupportedExtensions { extensions, .. } if extensions == [name]));
    }
    let error = requiring(&names).import().unwrap_err();
    assert!(error.to_string().contains("gltf-transform"), "{error}");
    assert!(matches!(error, ImportError::UnsupportedExtensions { extensions, .. } if extensions == names));
}

#[test]
fn unknown_optional_extensions_are_ignored() {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!(["VENDOR_unheard_of"]);
    gltf.json["extensions"] = json!({ "VENDOR_unheard_of": [1, 2] });
    gltf.json["nodes"][0]["extensions"] = json!({ "VENDOR_unheard_of": null });
    gltf.clean();
}

#[test]
fn optional_draco_uses_the_uncompressed_copy_or_is_refused() {
    let at = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    gltf.primitive()["extensions"] = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    assert_eq!(gltf.clean().meshes, Gltf::triangle().clean().meshes);
    gltf.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    gltf.refused(&[at]);
    // The same holds when only the indices are compressed.
    let mut gltf = Gltf::triangle();
    gltf.primitive()["extensions"] = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    let indices = gltf.push(
        "accessors",
        json!({ "componentType": 5121, "count": 3, "type": "SCALAR" }),
    );
    gltf.primitive()["indices"] = json!(indices);
    gltf.refused(&[at]);
}

#[test]
fn optional_meshopt_uses_the_fallback_or_is_refused() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mut gltf = Gltf::triangle();
        gltf.json["extensionsUsed"] = json!([name]);
        gltf.json["bufferViews"][0]["extensions"] = json!({ name: { "buffer": 1, "byteLength": 3 } });
        gltf.clean();
        gltf.json["bufferViews"][0]["buffer"] = json!(1);
        gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() }, { "byteLength": 36 }]);
        assert!(gltf.refused(&["/buffers/1"])[0].contains(name));
    }
}

#[test]
fn optional_instancing_shows_the_mesh_once_with_a_warning() {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    gltf.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {} } });
    let animation = gltf.warned(&["/nodes/0/extensions/EXT_mesh_gpu_instancing"]);
    assert_eq!(animation.parts.len(), 1);
}
