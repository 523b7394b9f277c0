//! Vertex caches that are refused.

use crate::{
    cache_builder::{Frame, TRIANGLE, frames, mdd, pc2, with_cache},
    gltf_builder::errors,
};
use restpose_bake::import::{FrameRange, ImportError, ImportSettings, import_obj_bytes};

/// The import must fail with errors at exactly these places. Gives the messages.
fn refused(name: &str, cache: &[u8], paths: &[&str]) -> Vec<String> {
    let errors = errors(with_cache(name, cache, &ImportSettings::default()));
    let found: Vec<_> = errors.iter().map(|fault| fault.path.as_str()).collect();
    assert_eq!(found, paths, "{errors:?}");
    errors.into_iter().map(|fault| fault.message).collect()
}

/// A word of a cache replaced.
fn patched(mut cache: Vec<u8>, offset: usize, word: [u8; 4]) -> Vec<u8> {
    cache[offset..offset + 4].copy_from_slice(&word);
    cache
}

fn whole_pc2() -> Vec<u8> {
    pc2(0.0, 1.0, &frames(3, 3))
}

fn whole_mdd() -> Vec<u8> {
    mdd(&[0.0, 1.0, 2.0], &frames(3, 3))
}

#[test]
fn a_wrong_point_count_names_both_files_and_both_counts() {
    for cache in [pc2(0.0, 1.0, &frames(2, 4)), mdd(&[0.0, 1.0], &frames(2, 4))] {
        let error = with_cache("walk", &cache, &ImportSettings::default()).unwrap_err();
        assert!(matches!(
            error,
            ImportError::PointCount {
                cache_points: 4,
                mesh_points: 3,
                ..
            }
        ));
        assert_eq!(
            error.to_string(),
            "walk: has 4 points, but mesh.obj has 3; expected as many, export both from one mesh"
        );
    }
}

#[test]
fn a_cache_cut_at_any_length_is_refused() {
    for (name, whole, header) in [("a.pc2", whole_pc2(), 32), ("a.mdd", whole_mdd(), 8 + 12)] {
        for length in 0..whole.len() {
            let path = if length < header { "header" } else { "" };
            let message = &refused(name, &whole[..length], &[path])[0];
            let complete = format!("the file has {} complete frames", length.saturating_sub(header) / 36);
            assert!(message.starts_with("truncated"), "{length}: {message}");
            assert_eq!(message.contains(&complete), length >= header, "{length}: {message}");
        }
    }
}

#[test]
fn no_frames_and_no_points_are_refused() {
    for (name, whole, offsets) in [("a.pc2", whole_pc2(), [16, 28]), ("a.mdd", whole_mdd(), [4, 0])] {
        for offset in offsets {
            for count in [0, -1i32] {
                let word = if name == "a.pc2" {
                    count.to_le_bytes()
                } else {
                    count.to_be_bytes()
                };
                let message = &refused(name, &patched(whole.clone(), offset, word), &["header"])[0];
                assert!(message.contains(&format!("declares {count} ")), "{message}");
            }
        }
    }
}

#[test]
fn huge_counts_are_refused_before_anything_is_allocated() {
    for count in [i32::MAX, 1 << 30, 1 << 29] {
        for (points, frames) in [(count, 3), (3, count), (count, count)] {
            let cache = patched(patched(whole_pc2(), 16, points.to_le_bytes()), 28, frames.to_le_bytes());
            assert!(refused("a.pc2", &cache, &[""])[0].starts_with("truncated"));
            let cache = patched(patched(whole_mdd(), 4, points.to_be_bytes()), 0, frames.to_be_bytes());
            let path = if frames == 3 { "" } else { "header" };
            assert!(refused("a.mdd", &cache, &[path])[0].starts_with("truncated"));
        }
    }
}

#[test]
fn other_formats_and_versions_are_refused() {
    assert!(refused("a.pc2", &whole_mdd(), &["header"])[0].contains("no PC2 file"));
    let cache = patched(whole_pc2(), 12, 2i32.to_le_bytes());
    assert!(refused("a.pc2", &cache, &["header"])[0].contains("version 2"));
}

#[test]
fn numbers_that_cannot_be_used_name_frame_and_point() {
    let mut frames = frames(3, 3);
    frames[1][2] = [f32::NAN, 1.0, f32::INFINITY];
    frames[2][0][1] = -1.1e30;
    for (name, cache) in [
        ("a.pc2", pc2(0.0, 1.0, &frames)),
        ("a.mdd", mdd(&[0.0, 1.0, 2.0], &frames)),
    ] {
        let messages = refused(name, &cache, &["frame 1 point 2", "frame 1 point 2", "frame 2 point 0"]);
        assert!(
            messages[0].starts_with("x is NaN") && messages[1].starts_with("z is inf"),
            "{messages:?}"
        );
        assert!(
            messages[2].starts_with("y is -1.1e30; magnitudes above 1e30"),
            "{messages:?}"
        );
    }
}

#[test]
fn faults_without_end_are_counted() {
    let broken: Vec<Frame> = vec![vec![[f32::NAN, 0.0, 0.0]; 3]; 1000];
    let errors = errors(with_cache("a.pc2", &pc2(0.0, 1.0, &broken), &ImportSettings::default()));
    assert_eq!(errors.len(), 1001);
    assert!(errors[1000].message.starts_with("2000 further"));
}

#[test]
fn times_that_do_not_increase_are_refused() {
    let frames = frames(3, 3);
    for (times, path) in [
        ([0.0, 0.0, 1.0], "frame 1"),
        ([0.0, 2.0, 1.0], "frame 2"),
        ([0.0, f32::NAN, 1.0], "frame 1"),
        ([f32::NEG_INFINITY, 0.0, 1.0], "frame 0"),
    ] {
        let cache = mdd(&times, &frames);
        assert!(refused("a.mdd", &cache, &[path])[0].contains("frame rate, which replaces"));
        let settings = ImportSettings {
            frame_rate: Some(24.0),
            ..ImportSettings::default()
        };
        with_cache("a.mdd", &cache, &settings).unwrap();
    }
    // So far from zero f32 has no numbers for single frames.
    assert!(refused("a.pc2", &pc2(1e9, 1.0, &frames), &["frame 1"])[0].contains("expected increasing times"));
}

#[test]
fn a_pc2_header_that_makes_no_times_is_refused() {
    for (start, step) in [
        (f32::NAN, 1.0),
        (0.0, f32::NAN),
        (f32::INFINITY, 1.0),
        (0.0, 0.0),
        (0.0, -1.0),
    ] {
        let message = &refused("a.pc2", &pc2(start, step, &frames(3, 3)), &["header"])[0];
        assert!(message.contains("sample rate above zero"), "{message}");
    }
}

#[test]
fn frame_rates_that_are_none_are_refused() {
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let settings = ImportSettings {
            frame_rate: Some(rate),
            ..ImportSettings::default()
        };
        let error = with_cache("a.pc2", &whole_pc2(), &settings).unwrap_err();
        assert!(matches!(error, ImportError::FrameRate { .. }), "{rate}: {error}");
    }
    for rate in [f64::MIN_POSITIVE, f64::MAX] {
        let settings = ImportSettings {
            frame_rate: Some(rate),
            ..ImportSettings::default()
        };
        assert_eq!(
            errors(with_cache("a.pc2", &whole_pc2(), &settings))[0].path,
            "frame 1",
            "{rate}"
        );
    }
}

#[test]
fn a_range_that_the_cache_does_not_have_is_refused() {
    for (first, last, step, text) in [
        (3, None, 1, "frames from 3, every 1, but it has 3 frames"),
        (0, Some(3), 1, "frames 0 to 3, every 1"),
        (2, Some(1), 1, "frames 2 to 1, every 1"),
        (0, None, 0, "frames from 0, every 0"),
    ] {
        let settings = ImportSettings {
            frame_rate: None,
            frames: FrameRange { first, last, step },
        };
        let error = with_cache("a.pc2", &whole_pc2(), &settings).unwrap_err();
        assert!(matches!(error, ImportError::FrameRange { frame_count: 3, .. }));
        assert!(error.to_string().contains(text), "{error}");
    }
}

#[test]
fn faults_of_the_mesh_come_before_those_of_its_cache() {
    let obj = format!("{TRIANGLE}f 1 2 9\n");
    let settings = ImportSettings::default();
    let error = import_obj_bytes(("m.obj", obj.as_bytes()), Some(("a.pc2", b"")), &settings).unwrap_err();
    assert!(
        error.to_string().starts_with("m.obj: 1 fault(s); first: line 5: "),
        "{error}"
    );
    let error = with_cache("a.pc2", b"", &settings).unwrap_err();
    assert!(
        error.to_string().starts_with("a.pc2: 1 fault(s); first: header: "),
        "{error}"
    );
}
