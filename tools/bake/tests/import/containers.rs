//! Files, chunks, buffers and their URIs.

use crate::gltf_builder::{Gltf, errors, glb, import_bytes};
use base64::{Engine, prelude::BASE64_STANDARD};
use restpose_bake::import::{ImportError, import, import_gltf_bytes};
use serde_json::json;
use std::{cell::RefCell, fs, io};

#[test]
fn glb_with_a_binary_chunk() {
    let animation = Gltf::triangle().clean();
    assert_eq!(
        animation.meshes[0].primitives[0].positions,
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    );
    assert_eq!(animation.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
}

#[test]
fn gltf_with_a_data_uri() {
    let gltf = Gltf::triangle();
    let base64 = BASE64_STANDARD.encode(&gltf.bin);
    let plain: String = gltf.bin.iter().map(|byte| format!("%{byte:02x}")).collect();
    let expected = gltf.clean();
    for uri in [
        format!("data:application/octet-stream;base64,{base64}"),
        format!("data:;base64,{}", base64.trim_end_matches('=')),
        format!(
            "DATA:application/gltf-buffer;charset=x;BASE64,{}",
            base64.replace('=', "%3D")
        ),
        format!("data:,{plain}"),
    ] {
        let imported = import_bytes(gltf.json_text(Some(&uri)).as_bytes()).unwrap();
        assert_eq!(imported.animation.meshes, expected.meshes, "{uri}");
    }
}

#[test]
fn external_buffers_are_percent_decoded_paths_beside_the_file() {
    let gltf = Gltf::triangle();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sub dir")).unwrap();
    fs::write(folder.path().join("sub dir/a+b.bin"), &gltf.bin).unwrap();
    let path = folder.path().join("scene.gltf");
    fs::write(&path, gltf.json_text(Some("sub%20dir/a+b.bin"))).unwrap();
    let animation = import(&path).unwrap().animation;
    assert_eq!(animation.meshes, gltf.clean().meshes);
    assert_eq!(animation.source_name, "scene.gltf");
}

#[test]
fn a_buffer_of_several_accessors_is_loaded_once_and_only_its_path_is_asked_for() {
    let gltf = Gltf::skinned();
    let asked = RefCell::new(Vec::new());
    let load = |uri: &str| {
        asked.borrow_mut().push(uri.to_owned());
        Ok(gltf.bin.clone())
    };
    import_gltf_bytes("x.gltf", gltf.json_text(Some("a.bin")).as_bytes(), &load).unwrap();
    assert_eq!(*asked.borrow(), ["a.bin"]);
}

#[test]
fn the_source_hash_covers_the_file_then_length_and_bytes_of_each_external_buffer() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() }, { "byteLength": 2, "uri": "b.bin" }]);
    let text = gltf.json_text(Some("a.bin"));
    let load = |uri: &str| {
        Ok(if uri == "a.bin" {
            gltf.bin.clone()
        } else {
            vec![7, 8, 9]
        })
    };
    let imported = import_gltf_bytes("x.gltf", text.as_bytes(), &load).unwrap();
    let mut expected = blake3::Hasher::new();
    expected.update(text.as_bytes());
    expected
        .update(&(gltf.bin.len() as u64).to_le_bytes())
        .update(&gltf.bin);
    expected.update(&3u64.to_le_bytes()).update(&[7, 8, 9]);
    assert_eq!(imported.animation.source_hash, *expected.finalize().as_bytes());
    let gltf = Gltf::triangle();
    assert_eq!(gltf.clean().source_hash, *blake3::hash(&gltf.glb()).as_bytes());
}

#[test]
fn byte_order_mark_padding_and_a_long_binary_chunk_are_accepted() {
    let gltf = Gltf::triangle();
    let expected = gltf.clean().meshes;
    let json = gltf.json_text(None);
    let mut long_bin = gltf.bin.clone();
    long_bin.extend([1; 40]);
    for bytes in [
        glb(format!("\u{feff}{json}").as_bytes(), &gltf.bin),
        glb(format!("{json}\0\0").as_bytes(), &gltf.bin),
        glb(json.as_bytes(), &long_bin),
    ] {
        let imported = import_bytes(&bytes).unwrap();
        assert_eq!((imported.animation.meshes, imported.faults), (expected.clone(), vec![]));
    }
    let uri = format!("data:;base64,{}", BASE64_STANDARD.encode(&gltf.bin));
    let text = format!("\u{feff}\n {}\r\n", gltf.json_text(Some(&uri)));
    assert_eq!(import_bytes(text.as_bytes()).unwrap().animation.meshes, expected);
}

#[test]
fn bytes_behind_the_file_are_ignored_with_a_warning() {
    let mut bytes = Gltf::triangle().glb();
    bytes.extend([0; 3]);
    let imported = import_bytes(&bytes).unwrap();
    assert_eq!(imported.faults.len(), 1);
}

#[test]
fn unknown_chunks_are_ignored() {
    let mut bytes = Gltf::triangle().glb();
    bytes.extend(4u32.to_le_bytes());
    bytes.extend(*b"EXTRxxxx");
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    assert_eq!(import_bytes(&bytes).unwrap().faults, []);
}

#[test]
fn what_is_not_geometry_or_motion_is_not_looked_at() {
    let mut gltf = Gltf::triangle();
    gltf.json["materials"] = json!([{ "alphaMode": 5 }]);
    gltf.json["images"] = json!("none");
    gltf.json["cameras"] = json!([{}]);
    gltf.json["accessors"][0]["min"] = json!([9, 9, 9]);
    gltf.json["accessors"][0]["max"] = json!("wrong");
    gltf.attributes()["NORMAL"] = json!(77);
    gltf.attributes()["_CUSTOM"] = json!(78);
    gltf.json["extras"] = json!([1, { "a": null }]);
    gltf.clean();
}

#[test]
fn whole_numbers_may_be_written_with_a_point() {
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["count"] = json!(3.0);
    gltf.clean();
    gltf.json["accessors"][0]["count"] = json!(2.5);
    gltf.refused(&["/accessors/0/count"]);
    gltf.json["accessors"][0]["count"] = json!(-3);
    gltf.refused(&["/accessors/0/count"]);
}

#[test]
fn schemes_and_absolute_paths_are_refused() {
    let gltf = Gltf::triangle();
    for uri in ["file:///a.bin", "http://a/b.bin", "/a.bin", "C:\\a.bin", "%2Fa.bin", ""] {
        let load = |_: &str| -> io::Result<Vec<u8>> { panic!("loaded") };
        let result = import_gltf_bytes("x.gltf", gltf.json_text(Some(uri)).as_bytes(), &load);
        let errors = errors(result);
        assert_eq!(
            errors.iter().map(|fault| fault.path.as_str()).collect::<Vec<_>>(),
            ["/buffers/0/uri"],
            "{uri}"
        );
    }
}

#[test]
fn every_missing_buffer_is_named() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] =
        json!([{ "byteLength": gltf.bin.len(), "uri": "gone.bin" }, { "byteLength": 4, "uri": "away.bin" }]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    fs::write(&path, gltf.json_text(None)).unwrap();
    let result = import(&path);
    let message = result.as_ref().unwrap_err().to_string();
    assert!(
        message.contains("scene.gltf") && message.contains("gone.bin"),
        "{message}"
    );
    let paths: Vec<_> = errors(result).into_iter().map(|fault| fault.path).collect();
    assert_eq!(paths, ["/buffers/0/uri", "/buffers/1/uri"]);
}

#[test]
fn buffers_that_are_no_files_are_refused() {
    let gltf = Gltf::triangle();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("folder.bin")).unwrap();
    let path = folder.path().join("scene.gltf");
    fs::write(&path, gltf.json_text(Some("folder.bin"))).unwrap();
    assert_eq!(errors(import(&path))[0].path, "/buffers/0/uri");
}

#[test]
fn a_buffer_without_data_is_a_fault_only_when_it_is_read() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() }, { "byteLength": 100 }]);
    gltf.clean();
    let result = import_bytes(gltf.json_text(None).as_bytes());
    assert_eq!(errors(result)[0].path, "/buffers/0");
}

#[test]
fn a_short_buffer_is_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() + 4 }]);
    gltf.refused(&["/buffers/0/byteLength"]);
}

#[test]
fn other_versions_are_named() {
    let mut gltf = Gltf::triangle();
    gltf.json["asset"] = json!({ "version": "1.0" });
    gltf.json["nodes"] = json!({ "a": {} });
    let error = gltf.import().unwrap_err();
    assert!(
        matches!(&error, ImportError::UnknownFormat { found, .. } if found.contains("1.0")),
        "{error}"
    );
    gltf = Gltf::triangle();
    gltf.json["asset"] = json!({ "version": "2.1", "minVersion": "2.1" });
    let error = gltf.import().unwrap_err();
    assert!(
        matches!(&error, ImportError::UnknownFormat { found, .. } if found.contains("2.1")),
        "{error}"
    );
    let mut bytes = Gltf::triangle().glb();
    bytes[4] = 1;
    let error = import_bytes(&bytes).unwrap_err();
    assert!(
        matches!(&error, ImportError::UnknownFormat { found, .. } if found.contains("version 1")),
        "{error}"
    );
}
