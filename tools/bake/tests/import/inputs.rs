//! Which files go together, and which are opened.

use crate::cache_builder::{TRIANGLE, clean, frames, mdd, pc2, warned};
use crate::gltf_builder::Gltf;
use restpose_bake::import::{ImportError, ImportSettings, import, import_files};
use std::{fs, path::PathBuf};

fn written(folder: &tempfile::TempDir, files: &[(&str, &[u8])]) -> Vec<PathBuf> {
    let write = |(name, bytes): &(&str, &[u8])| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    files.iter().map(write).collect()
}

#[test]
fn mesh_and_cache_come_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let frames = frames(2, 3);
    let inputs = written(
        &folder,
        &[
            ("m.obj", TRIANGLE.as_bytes()),
            ("a.pc2", &pc2(0.0, 1.0, &frames)),
            ("b.mdd", &mdd(&[0.0, 1.0], &frames)),
        ],
    );
    for cache in [1, 2] {
        let import = |order: [usize; 2]| {
            let inputs = order.map(|input| inputs[input].clone());
            clean(import_files(&inputs, &ImportSettings::default()))
        };
        let animation = import([0, cache]);
        assert_eq!(animation.clips[0].name, ["", "a", "b"][cache]);
        assert_eq!(animation, import([cache, 0]));
    }
}

#[test]
fn a_mesh_alone_is_static() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = written(&folder, &[("m.obj", TRIANGLE.as_bytes())]);
    let animation = clean(import(&inputs[0]));
    assert!(animation.clips.is_empty() && animation.caches.is_empty());
    assert_eq!(
        (animation.source_name.as_str(), animation.parts[0].name.as_str()),
        ("m.obj", "m")
    );
}

#[test]
fn gltf_ignores_frame_settings_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = written(&folder, &[("m.glb", &Gltf::triangle().glb())]);
    let settings = ImportSettings {
        frame_rate: Some(30.0),
        ..ImportSettings::default()
    };
    let (animation, fault) = warned(import_files(&inputs, &settings));
    assert!(fault.message.contains("ignored"), "{fault}");
    assert_eq!(animation, clean(import(&inputs[0])));
}

#[test]
fn what_does_not_go_together_is_refused_with_what_does() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = written(
        &folder,
        &[
            ("m.obj", TRIANGLE.as_bytes()),
            ("x.txt", b"x"),
            ("a.pc2", b""),
            ("b.mdd", b""),
        ],
    );
    let refused = |chosen: &[usize]| {
        let chosen: Vec<PathBuf> = chosen.iter().map(|input| inputs[*input].clone()).collect();
        import_files(&chosen, &ImportSettings::default()).unwrap_err()
    };
    assert!(matches!(refused(&[]), ImportError::NoInput));
    assert!(matches!(refused(&[1]), ImportError::UnknownFormat { .. }));
    assert!(matches!(refused(&[0, 1]), ImportError::UnknownFormat { .. }));
    assert!(matches!(refused(&[2]), ImportError::Inputs { .. }));
    let error = refused(&[2, 0, 3]);
    assert!(
        matches!(&error, ImportError::Inputs { path, .. } if *path == inputs[3]),
        "{error}"
    );
    for text in [error.to_string(), refused(&[1]).to_string()] {
        for kind in [".gltf", ".glb", ".obj", ".pc2", ".mdd", "folder"] {
            assert!(text.contains(kind), "{text}");
        }
    }
}

#[test]
fn a_missing_file_among_several_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = written(&folder, &[("m.obj", TRIANGLE.as_bytes())]);
    inputs.push(folder.path().join("gone.pc2"));
    let error = import_files(&inputs, &ImportSettings::default()).unwrap_err();
    assert!(
        matches!(&error, ImportError::Read { path, .. } if *path == inputs[1]),
        "{error}"
    );
    assert_eq!(error.path(), Some(inputs[1].as_path()));
}

#[cfg(unix)]
#[test]
fn what_is_no_ordinary_file_is_not_opened() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("f2.obj");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let inputs = written(&folder, &[("f1.obj", TRIANGLE.as_bytes())]);
    let device = PathBuf::from("/dev/zero");
    let folder = folder.path().to_owned();
    for (inputs, at_fault) in [
        (vec![socket.clone()], &socket),
        (vec![device.clone()], &device),
        (vec![inputs[0].clone(), device.clone()], &device),
        (vec![folder], &socket),
    ] {
        let error = import_files(&inputs, &ImportSettings::default()).unwrap_err();
        assert!(
            matches!(&error, ImportError::Read { path, .. } if path == at_fault),
            "{error}"
        );
        assert!(error.to_string().contains("not an ordinary file"), "{error}");
    }
}
