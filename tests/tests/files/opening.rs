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

fn map_written(path: &Path) -> Result<Asset, OpenError> {
    // SAFETY: as of `map`; and the file was written by this library, or is refused for what stands in its first bytes.
    unsafe { Asset::map_written(path) }
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
        for asset in [map, map_written, Asset::open].map(|open| open(&path).unwrap()) {
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
fn files_that_are_none_are_refused_alike_by_all_ways_of_opening() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.rpose");
    for open in [map as fn(&Path) -> Result<Asset, OpenError>, map_written, Asset::open] {
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

/// Any byte, in any section: the checksums cover them all.
#[test]
fn damage_is_found_without_a_look_at_the_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.rpose");
    let scene = &sample_scenes()[0];
    let baked = bake(&import(scene).unwrap().animation, &BakeSettings::default(), &NoProgress).unwrap();
    let intact = restpose_formats::write(&baked.model).unwrap();
    for at in (0..intact.len()).step_by(intact.len() / 97) {
        let mut damaged = intact.clone();
        damaged[at] ^= 0x10;
        fs::write(&path, &damaged).unwrap();
        for open in [map_written, Asset::open] {
            assert!(matches!(open(&path), Err(OpenError::Format { .. })), "byte {at}");
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
