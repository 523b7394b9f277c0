//! Files as a runtime meets them: mapped, read, rewritten; missing, empty, foreign, cut short.
#![expect(unsafe_code, reason = "mapping a file is a promise that nobody changes it")]

use restpose_bake::{BakeSettings, NoProgress, bake, import::import, write_file};
use restpose_formats::FormatError;
use restpose_runtime::{Asset, Frame, OpenError, Scene};
use restpose_tests::sample_scenes;
use std::{fs, path::Path};

fn map(path: &Path) -> Result<Asset, OpenError> {
    // SAFETY: the file lies in a folder that only this test knows, and the test does not write it while it is mapped.
    unsafe { Asset::map(path) }
}

#[test]
fn files_are_written_mapped_read_and_rewritten_alike() {
    let folder = tempfile::tempdir().unwrap();
    for scene in sample_scenes() {
        let baked = bake(
            &import(&scene).unwrap().animation,
            &BakeSettings::default(),
            &NoProgress,
        )
        .unwrap();
        let bytes = restpose_formats::write(&baked.model).unwrap();
        let path = folder.path().join("scene.rpose");
        write_file(&path, &bytes).unwrap();
        for asset in [map(&path).unwrap(), Asset::open(&path).unwrap()] {
            assert!(asset.model().to_model() == baked.model, "{}", scene.display());
            assert!(
                restpose_formats::write(&asset.model().to_model()).unwrap() == bytes,
                "{}",
                scene.display()
            );
        }
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing temporary is left"
        );
    }
}

#[test]
fn files_that_are_none_are_refused_alike_by_both_ways_of_opening() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.rpose");
    for open in [map as fn(&Path) -> Result<Asset, OpenError>, Asset::open] {
        assert!(matches!(
            open(&folder.path().join("missing")),
            Err(OpenError::Read { .. })
        ));
        assert!(matches!(
            open(folder.path()),
            Err(OpenError::Read { .. } | OpenError::Format { .. })
        ));
        for (contents, name) in [
            (&b""[..], "empty"),
            (b"\x8bRPO", "cut in the magic"),
            (b"glTF binary or what", "foreign"),
        ] {
            fs::write(&path, contents).unwrap();
            match open(&path) {
                Err(OpenError::Format { path: named, source }) => {
                    assert_eq!(named, path, "{name}");
                    assert!(
                        matches!(source, FormatError::Truncated { .. } | FormatError::NotRestpose { .. }),
                        "{name}: {source}"
                    );
                }
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}

#[test]
fn assets_scenes_and_frames_cross_threads() {
    fn crosses<T: Send + Sync>() {}
    crosses::<Asset>();
    crosses::<Scene>();
    crosses::<Frame>();
}
