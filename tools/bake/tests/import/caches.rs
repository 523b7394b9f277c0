//! PC2 and MDD files that move an OBJ mesh.

use crate::cache_builder::{Frame, TRIANGLE, clean, frames, mdd, pc2, warned, with_cache};
use restpose_bake::import::{
    Animation, Channel, ChannelTarget, FrameRange, ImportSettings, Local, Primitive, import_obj_bytes,
};
use restpose_formats::rows::Interpolation;
use std::time::{Duration, Instant};

fn default() -> ImportSettings {
    ImportSettings::default()
}

fn at_rate(rate: f64) -> ImportSettings {
    ImportSettings {
        frame_rate: Some(rate),
        ..default()
    }
}

fn range(first: usize, last: Option<usize>, step: usize) -> ImportSettings {
    ImportSettings {
        frames: FrameRange { first, last, step },
        ..default()
    }
}

fn times(animation: &Animation) -> &[f32] {
    &animation.clips[0].channels[0].times
}

fn options(animation: &Animation) -> Vec<(&str, &str)> {
    let options = animation.import_options.iter();
    options.map(|(name, value)| (name.as_str(), value.as_str())).collect()
}

fn all_frames(animation: &Animation) -> Vec<Frame> {
    let cache = &animation.caches[0];
    (0..cache.frame_count())
        .map(|frame| cache.frame(frame).to_vec())
        .collect()
}

#[test]
fn pc2_gives_a_cache_and_a_clip() {
    let frames = frames(3, 3);
    let animation = clean(with_cache("walk.pc2", &pc2(0.0, 1.0, &frames), &default()));
    assert_eq!((animation.caches.len(), animation.caches[0].point_count), (1, 3));
    assert_eq!(all_frames(&animation), frames);
    assert_eq!(
        (animation.clips.len(), animation.clips[0].label(0).as_str()),
        (1, "walk")
    );
    let expected = Channel {
        node: 0,
        target: ChannelTarget::Frame,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0 / 24.0, 2.0 / 24.0],
        values: vec![0.0, 1.0, 2.0],
    };
    assert_eq!(animation.clips[0].channels, [expected]);
    assert_eq!(
        (animation.parts[0].name.as_str(), animation.parts[0].cache),
        ("mesh", Some(0))
    );
    assert_eq!(animation.source_name, "mesh.obj");
    // The mesh's own positions do not count.
    let Primitive { positions, points, .. } = &animation.meshes[0].primitives[0];
    assert_eq!((positions, points.as_slice()), (&frames[0], [0, 1, 2].as_slice()));
    assert!(matches!(
        animation.nodes[0].local,
        Local::Trs {
            scale: [1.0, 1.0, 1.0],
            ..
        }
    ));
}

#[test]
fn pc2_is_told_by_content_and_mdd_is_what_else_is_left() {
    let frames = frames(2, 3);
    let animation = clean(with_cache("walk.mdd", &pc2(0.0, 1.0, &frames), &default()));
    assert_eq!(all_frames(&animation), frames);
    let animation = clean(with_cache("walk", &mdd(&[0.0, 1.0], &frames), &default()));
    assert_eq!(all_frames(&animation), frames);
}

#[test]
fn pc2_frames_are_at_start_plus_step_by_the_frame_rate() {
    let bytes = pc2(6.0, 0.5, &frames(3, 3));
    let animation = clean(with_cache("a.pc2", &bytes, &default()));
    assert_eq!(times(&animation), [0.25, 6.5 / 24.0, 7.0 / 24.0]);
    assert_eq!(
        options(&animation),
        [
            ("frame_rate", "24"),
            ("first_frame", "0"),
            ("last_frame", "2"),
            ("frame_step", "1")
        ]
    );
    let animation = clean(with_cache("a.pc2", &bytes, &at_rate(0.5)));
    assert_eq!(times(&animation), [12.0, 13.0, 14.0]);
    assert_eq!(options(&animation)[0], ("frame_rate", "0.5"));
}

#[test]
fn mdd_has_its_own_times_which_a_frame_rate_replaces() {
    let frames = frames(3, 3);
    let bytes = mdd(&[0.5, 1.0, 4.0], &frames);
    let animation = clean(with_cache("a.mdd", &bytes, &default()));
    assert_eq!(
        (times(&animation), all_frames(&animation)),
        ([0.5, 1.0, 4.0].as_slice(), frames)
    );
    assert_eq!(options(&animation)[0], ("first_frame", "0"));
    let animation = clean(with_cache("a.mdd", &bytes, &at_rate(2.0)));
    assert_eq!(times(&animation), [0.0, 0.5, 1.0]);
    assert_eq!(options(&animation)[0], ("frame_rate", "2"));
}

#[test]
fn a_range_of_frames_is_kept_at_its_times() {
    let frames = frames(8, 3);
    let kept: Vec<Frame> = [2, 4, 6].map(|frame| frames[frame].clone()).to_vec();
    for (cache, rate) in [
        (pc2(1.0, 1.0, &frames), 24.0),
        (mdd(&[3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0], &frames), 1.0),
    ] {
        let animation = clean(with_cache("a", &cache, &range(2, Some(7), 2)));
        assert_eq!(all_frames(&animation), kept);
        let first = if rate == 1.0 { 5.0 } else { 3.0 };
        assert_eq!(
            times(&animation),
            [first / rate, (first + 2.0) / rate, (first + 4.0) / rate]
        );
        assert_eq!(animation.clips[0].channels[0].values, [0.0, 1.0, 2.0]);
        assert_eq!(animation.meshes[0].primitives[0].positions, kept[0]);
        let range = [("first_frame", "2"), ("last_frame", "7"), ("frame_step", "2")];
        assert!(options(&animation).ends_with(&range));
    }
}

#[test]
fn a_single_frame_is_a_static_mesh_with_a_warning() {
    let frames = frames(3, 3);
    let whole = pc2(0.0, 1.0, &frames);
    // Of one frame the times do not matter, not even broken ones.
    let one = pc2(0.0, 0.0, &frames[..1]);
    for (cache, settings, frame) in [
        (&one, default(), 0),
        (&whole, range(1, Some(1), 1), 1),
        (&whole, range(0, None, 9), 0),
    ] {
        let (animation, fault) = warned(with_cache("a.pc2", cache, &settings));
        assert!(fault.message.contains("one frame"), "{fault}");
        assert!(animation.caches.is_empty() && animation.clips.is_empty());
        let primitive = &animation.meshes[0].primitives[0];
        assert_eq!(
            (&primitive.positions, primitive.points.len(), animation.parts[0].cache),
            (&frames[frame], 0, None)
        );
        assert_eq!(options(&animation)[0], ("first_frame", ["0", "1"][frame]));
    }
}

#[test]
fn bytes_behind_the_last_frame_are_ignored_with_a_warning() {
    let frames = frames(2, 3);
    for mut bytes in [pc2(0.0, 1.0, &frames), mdd(&[0.0, 1.0], &frames)] {
        bytes.extend([0xFF; 5]);
        let (animation, fault) = warned(with_cache("a", &bytes, &default()));
        assert_eq!(all_frames(&animation), frames);
        assert!(fault.message.starts_with("5 bytes behind"), "{fault}");
    }
}

#[test]
fn a_frame_before_zero_is_kept_with_a_warning() {
    let (animation, fault) = warned(with_cache("a.pc2", &pc2(-24.0, 1.0, &frames(2, 3)), &default()));
    assert_eq!((times(&animation)[0], fault.path.as_str()), (-1.0, "frame 0"));
}

#[test]
fn what_is_in_frames_that_are_not_kept_does_not_matter() {
    let mut frames = frames(3, 3);
    frames[1][0][0] = f32::NAN;
    clean(with_cache("a.pc2", &pc2(0.0, 1.0, &frames), &range(0, None, 2)));
    clean(with_cache("a.mdd", &mdd(&[0.0, 7.0, 1.0], &frames), &range(0, None, 2)));
}

#[test]
fn coordinates_from_tiny_to_huge() {
    let frames: Vec<Frame> = [1e-20, 1e20, 1e30]
        .map(|size| vec![[size, 0.0, 0.0], [0.0, size, 0.0], [-size; 3]])
        .to_vec();
    assert_eq!(
        all_frames(&clean(with_cache("a.pc2", &pc2(0.0, 1.0, &frames), &default()))),
        frames
    );
}

#[test]
fn a_hundred_thousand_frames_of_one_triangle() {
    let frames = frames(100_000, 3);
    let seconds: Vec<f32> = (0..100_000).map(|frame| frame as f32).collect();
    for cache in [pc2(0.0, 1.0, &frames), mdd(&seconds, &frames)] {
        let start = Instant::now();
        let animation = clean(with_cache("a", &cache, &default()));
        assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
        assert_eq!(animation.caches[0].frame(99_999), frames[99_999]);
        assert_eq!(
            (times(&animation).len(), animation.clips[0].channels[0].values[99_999]),
            (100_000, 99_999.0)
        );
    }
}

#[test]
fn the_source_hash_covers_length_and_bytes_of_mesh_then_cache() {
    let cache = pc2(0.0, 1.0, &frames(2, 3));
    let mut hasher = blake3::Hasher::new();
    for bytes in [TRIANGLE.as_bytes(), &cache] {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    }
    let animation = clean(with_cache("a.pc2", &cache, &default()));
    assert_eq!(animation.source_hash, *hasher.finalize().as_bytes());
    let alone = clean(import_obj_bytes(("m.obj", TRIANGLE.as_bytes()), None, &default()));
    assert_eq!(alone.source_hash, *blake3::hash(TRIANGLE.as_bytes()).as_bytes());
}

#[test]
fn settings_without_a_use_are_ignored_with_a_warning() {
    for settings in [at_rate(30.0), range(0, Some(0), 1)] {
        let (_, fault) = warned(import_obj_bytes(("m.obj", TRIANGLE.as_bytes()), None, &settings));
        assert!(fault.message.contains("ignored"), "{fault}");
    }
}
