//! OBJ files, one per frame.

use crate::cache_builder::{TRIANGLE, clean, warned};
use restpose_bake::import::{
    ChannelTarget, ConnectivityDifference, FrameRange, ImportError, ImportSettings, Imported, import, import_files,
};
use std::{fs, path::PathBuf};
use tempfile::TempDir;

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// [`TRIANGLE`], moved.
fn moved(x: f32) -> String {
    format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
}

fn import_folder(folder: &TempDir, settings: &ImportSettings) -> Result<Imported, ImportError> {
    import_files(&[folder.path().to_owned()], settings)
}

fn range(first: usize, last: Option<usize>, step: usize) -> ImportSettings {
    ImportSettings {
        frame_rate: Some(10.0),
        frames: FrameRange { first, last, step },
    }
}

/// The first coordinate of the first point in every frame.
fn xs(imported: Result<Imported, ImportError>) -> Vec<f32> {
    let cache = &clean(imported).caches[0];
    (0..cache.frame_count()).map(|frame| cache.frame(frame)[0][0]).collect()
}

#[test]
fn a_folder_is_played_in_natural_order_of_names() {
    let names = ["f1.obj", "f2.obj", "f010.OBJ", "f11.obj", "f100.obj"];
    let texts: Vec<String> = (0..5u8).map(|frame| moved(f32::from(frame))).collect();
    let mut files: Vec<(&str, &str)> = names.into_iter().zip(texts.iter().map(String::as_str)).collect();
    files.reverse();
    files.extend([("readme.txt", "x"), (".hidden.obj", "x"), ("f3.obj.bak", "x")]);
    let folder = folder(&files);
    let animation = clean(import(folder.path()));
    let name = folder.path().file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!(
        (
            &animation.source_name,
            &animation.clips[0].name,
            &animation.parts[0].name
        ),
        (&name, &name, &name)
    );
    let channel = &animation.clips[0].channels[0];
    assert_eq!((channel.node, channel.target), (0, ChannelTarget::Frame));
    assert_eq!(channel.times, [0.0, 1.0 / 24.0, 2.0 / 24.0, 3.0 / 24.0, 4.0 / 24.0]);
    assert_eq!(channel.values, [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(animation.parts[0].cache, Some(0));
    assert_eq!(xs(import(folder.path())), [0.0, 1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn a_list_is_played_in_the_order_given() {
    let folder = folder(&[("a1.obj", &moved(1.0)), ("a2.obj", &moved(2.0))]);
    let inputs = ["a2.obj", "a1.obj", "a2.obj"].map(|name| folder.path().join(name));
    let animation = clean(import_files(&inputs, &ImportSettings::default()));
    assert_eq!(
        (animation.source_name.as_str(), animation.clips[0].name.as_str()),
        ("a2.obj", "a2")
    );
    assert_eq!(xs(import_files(&inputs, &ImportSettings::default())), [2.0, 1.0, 2.0]);
}

#[test]
fn faces_and_groups_are_those_of_the_first_kept_file() {
    let first = format!("o box\n{TRIANGLE}");
    // Relative corners, other groups, other texture coordinates: the same faces.
    let second = "v 5 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\no other\nf -3/1 -2/1 -1/1\n";
    let folder = folder(&[("1.obj", &first), ("2.obj", second)]);
    let animation = clean(import(folder.path()));
    assert_eq!((animation.parts.len(), animation.parts[0].name.as_str()), (1, "box"));
    assert_eq!(animation.caches[0].frame(1)[0], [5.0, 0.0, 0.0]);
}

#[test]
fn only_kept_files_are_opened() {
    let folder = folder(&[
        ("0.obj", "x"),
        ("1.obj", &moved(1.0)),
        ("2.obj", "x"),
        ("3.obj", &moved(3.0)),
        ("4.obj", "x"),
    ]);
    let settings = range(1, Some(3), 2);
    let animation = clean(import_folder(&folder, &settings));
    assert_eq!(animation.clips[0].channels[0].times, [0.1, 0.3]);
    let options = [
        ("frame_rate", "10"),
        ("first_frame", "1"),
        ("last_frame", "3"),
        ("frame_step", "2"),
    ];
    assert_eq!(
        animation.import_options,
        options.map(|(name, value)| (name.to_owned(), value.to_owned()))
    );
    assert_eq!(xs(import_folder(&folder, &settings)), [1.0, 3.0]);
    let mut hasher = blake3::Hasher::new();
    for text in [moved(1.0), moved(3.0)] {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    assert_eq!(animation.source_hash, *hasher.finalize().as_bytes());
}

#[test]
fn a_folder_of_one_file_is_a_static_mesh_with_a_warning() {
    let folder = folder(&[("a.obj", &moved(2.0))]);
    let (animation, _) = warned(import(folder.path()));
    assert!(animation.caches.is_empty() && animation.clips.is_empty());
    assert_eq!(animation.meshes[0].primitives[0].positions[0], [2.0, 0.0, 0.0]);
    assert_eq!(animation.source_hash, *blake3::hash(moved(2.0).as_bytes()).as_bytes());
}

#[test]
fn an_empty_folder_is_refused() {
    let folder = folder(&[("a.txt", "x")]);
    let error = import(folder.path()).unwrap_err();
    assert!(
        matches!(&error, ImportError::Inputs { path, .. } if path == folder.path()),
        "{error}"
    );
}

#[test]
fn a_frame_with_another_mesh_is_named_with_the_difference() {
    let quad = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\nf 3 2 1\n";
    let cases = [
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n",
            ConnectivityDifference::PointCount { expected: 4, found: 3 },
            "has 3 points, the first frame 4",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 2 2\nf 1 2 3 4\nf 3 2 1\n",
            ConnectivityDifference::PointCount { expected: 4, found: 5 },
            "has 5 points, the first frame 4",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 3 4\nf 3 2 1\n",
            ConnectivityDifference::FaceCount { expected: 2, found: 3 },
            "has 3 faces, the first frame 2",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 1 4\n",
            ConnectivityDifference::Corners {
                face: 0,
                line: 5,
                expected: vec![0, 1, 2, 3],
                found: vec![0, 1, 2],
            },
            "face 1 (line 5) has the corners 1 2 3, in the first frame 1 2 3 4",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\nf 3 2 9\n",
            ConnectivityDifference::Corners {
                face: 1,
                line: 6,
                expected: vec![2, 1, 0],
                found: vec![2, 1, 8],
            },
            "face 2 (line 6) has the corners 3 2 9, in the first frame 3 2 1",
        ),
    ];
    for (other, expected, text) in cases {
        let folder = folder(&[
            ("a1.obj", quad),
            ("a2.obj", quad),
            ("a3.obj", other),
            ("a4.obj", TRIANGLE),
        ]);
        let error = import(folder.path()).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
        let ImportError::Connectivity {
            path,
            frame,
            first,
            difference,
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!(
            (path, frame, first),
            (folder.path().join("a3.obj"), 2, folder.path().join("a1.obj"))
        );
        assert_eq!(difference, expected);
    }
}

#[test]
fn corners_without_end_are_cut_in_messages() {
    let face = |last: &str| format!("v 0 0 0\nv 1 0 0\nf {}{last}\n", "1 ".repeat(10_000));
    let folder = folder(&[("1.obj", &face("1")), ("2.obj", &face("2"))]);
    let text = import(folder.path()).unwrap_err().to_string();
    assert!(text.contains("(10001 in all)") && text.len() < 1000, "{}", text.len());
}

#[test]
fn a_frame_that_cannot_be_read_is_named_with_its_line() {
    let folder = folder(&[("1.obj", TRIANGLE), ("2.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n")]);
    let ImportError::Faults { path, faults } = import(folder.path()).unwrap_err() else {
        panic!("expected faults");
    };
    assert_eq!((path, faults[0].path.as_str()), (folder.path().join("2.obj"), "line 2"));
}

#[test]
fn times_that_f32_cannot_tell_apart_are_refused_before_any_file_is_read() {
    let folder = folder(&[("1.obj", "x"), ("2.obj", "x")]);
    let settings = ImportSettings {
        frame_rate: Some(f64::MAX),
        ..ImportSettings::default()
    };
    let error = import_folder(&folder, &settings).unwrap_err();
    assert!(
        matches!(&error, ImportError::Faults { path, .. } if path == folder.path()),
        "{error}"
    );
}

#[test]
fn a_sequence_is_the_same_as_its_vertex_cache() {
    let frames = crate::cache_builder::frames(5, 3);
    let text = |frame: &crate::cache_builder::Frame| {
        let points: String = frame.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        points + "f 1 2 3\n"
    };
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = (0..frames.len())
        .map(|frame| folder.path().join(format!("{frame}.obj")))
        .collect();
    for (path, frame) in paths.iter().zip(&frames) {
        fs::write(path, text(frame)).unwrap();
    }
    let cache = folder.path().join("0.pc2");
    fs::write(&cache, crate::cache_builder::pc2(0.0, 1.0, &frames)).unwrap();
    let settings = range(1, None, 2);
    let mut sequence = clean(import_files(&paths, &settings));
    let cached = clean(import_files(&[cache, paths[0].clone()], &settings));
    sequence.source_hash = cached.source_hash;
    assert_eq!(sequence, cached);
}
