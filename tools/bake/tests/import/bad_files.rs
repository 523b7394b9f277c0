//! Files that are missing, cut short, or something else.

use crate::gltf_builder::{Gltf, errors, glb, import_bytes};
use restpose_bake::import::{ImportError, import};
use std::{fs, path::Path};

#[test]
fn a_missing_file_is_named() {
    let error = import(Path::new("nowhere/gone.glb")).unwrap_err();
    assert!(matches!(&error, ImportError::Read { path, .. } if path == Path::new("nowhere/gone.glb")));
    assert!(error.to_string().contains("gone.glb"));
}

#[test]
fn an_empty_file_and_text_are_of_unknown_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.glb");
    for text in ["", " \n ", "hello", "g", "gl", "glT", "[1]", "o cube\nv 0 0 0\n"] {
        fs::write(&path, text).unwrap();
        let error = import(&path).unwrap_err();
        assert!(
            matches!(&error, ImportError::UnknownFormat { path: found, .. } if *found == path),
            "{text:?}: {error}"
        );
    }
}

#[test]
fn json_that_is_not_gltf_is_refused() {
    let cases: [(&str, &str); 6] = [
        ("{", ""),
        ("{}", ""),
        (r#"{"asset":{"version":"2.0"},"nodes":{}}"#, "/nodes"),
        (r#"{"asset":{}}"#, "/asset"),
        (
            r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"mesh":"#,
            "/nodes/1/mesh",
        ),
        (
            r#"{"asset":{"version":"2.0"},"extensionsRequired":[1]}"#,
            "/extensionsRequired/0",
        ),
    ];
    for (text, path) in cases {
        let errors = errors(import_bytes(text.as_bytes()));
        assert_eq!(errors.len(), 1, "{text}: {errors:?}");
        assert!(path.starts_with(&errors[0].path), "{text}: {errors:?}");
    }
}

#[test]
fn nesting_without_end_is_refused() {
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}"#, "[".repeat(1_000_000));
    assert_eq!(errors(import_bytes(text.as_bytes())).len(), 1);
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{}"#,
        r#"{"extras":"#.repeat(1_000_000)
    );
    assert_eq!(errors(import_bytes(text.as_bytes())).len(), 1);
}

#[test]
fn every_element_that_does_not_fit_is_reported() {
    let text = r#"{"asset":{"version":"2.0"},
        "nodes":[{"mesh":"x"},{},{"children":[1,-1]},{"rotation":[0,0,1]}],
        "accessors":[{"count":1}],
        "meshes":[{"primitives":[{"attributes":{"a/b~c":null}}]}]}"#;
    let paths: Vec<_> = errors(import_bytes(text.as_bytes()))
        .into_iter()
        .map(|fault| fault.path)
        .collect();
    let expected = [
        "/nodes/0/mesh",
        "/nodes/2/children/1",
        "/nodes/3/rotation",
        "/meshes/0/primitives/0/attributes/a~1b~0c",
        "/accessors/0",
    ];
    assert_eq!(paths, expected);
}

#[test]
fn a_glb_cut_at_any_length_is_refused() {
    let bytes = Gltf::skinned().glb();
    import_bytes(&bytes).unwrap();
    for length in 0..bytes.len() {
        let error = import_bytes(&bytes[..length]).unwrap_err();
        match &error {
            ImportError::UnknownFormat { .. } => assert!(length < 4, "{length}: {error}"),
            ImportError::Faults { .. } => assert!(length >= 4, "{length}: {error}"),
            other => panic!("{length}: {other}"),
        }
    }
}

#[test]
fn a_gltf_cut_at_any_length_is_refused() {
    let text = Gltf::skinned().json_text(None);
    for length in 0..text.len() {
        import_bytes(&text.as_bytes()[..length]).unwrap_err();
    }
}

#[test]
fn a_glb_cut_to_any_length_that_its_header_admits_is_refused() {
    let whole = Gltf::skinned().glb();
    for length in 12..whole.len() {
        let mut bytes = whole[..length].to_vec();
        bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        import_bytes(&bytes).unwrap_err();
    }
}

#[test]
fn a_glb_with_any_byte_of_its_headers_changed_does_not_panic() {
    let whole = Gltf::skinned().glb();
    let json = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    for place in (0..20).chain(20 + json..28 + json) {
        for value in 0..=255 {
            let mut bytes = whole.clone();
            bytes[place] = value;
            let _ = import_bytes(&bytes);
        }
    }
}

#[test]
fn a_glb_without_json_is_refused() {
    let mut bytes = Gltf::triangle().glb();
    bytes[16] = b'X';
    assert_eq!(errors(import_bytes(&bytes)).len(), 1);
    let header: Vec<u8> = [*b"glTF", [2, 0, 0, 0], [12, 0, 0, 0]].concat();
    assert_eq!(errors(import_bytes(&header)).len(), 1);
    assert_eq!(errors(import_bytes(&glb(b"", &[]))).len(), 1);
}
