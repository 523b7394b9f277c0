//! `measure_motion` on a sample, with settings that take no time.

use restpose_bake::{
    BakeSettings, NoProgress,
    import::{Animation, FrameRange, ImportSettings, import_files},
};
use restpose_formats::TreeKind;
use restpose_measure::{
    MeasureError,
    motion::{MotionReport, MotionSegment, MotionSettings, measure_motion, page},
};
use serde_json::{Value, to_value};
use std::{path::Path, sync::LazyLock};

/// A few frames of a keyframed sample.
fn goose() -> Animation {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
    let files = ["goose.obj", "goose.pc2"].map(|name| folder.join(name));
    let settings = ImportSettings {
        frames: FrameRange {
            last: Some(8),
            ..FrameRange::default()
        },
        ..ImportSettings::default()
    };
    import_files(&files, &settings).unwrap().animation
}

fn small() -> MotionSettings {
    MotionSettings {
        poses: 4,
        threads: vec![1, 2],
        picture_side: 24,
        random_rays: 300,
        repeats: 1,
        updates: 1,
        seed: 5,
    }
}

/// Two segments, which pay where nodes have no boxes at keys, and no free motion however much it would pay.
fn bake() -> BakeSettings {
    let mut settings = BakeSettings {
        tree: TreeKind::Kd,
        segments: 2,
        size_worth: 0.0,
        rays_per_frame: 0.0,
        ..BakeSettings::default()
    };
    settings.motion.max_clusters = 5;
    settings
}

fn measured() -> MotionReport {
    measure_motion(&goose(), &bake(), &small(), &NoProgress).unwrap()
}

static MEASURED: LazyLock<MotionReport> = LazyLock::new(measured);

/// The numbers that no clock has touched.
fn timeless(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|key, _| {
                let clock = ["time", "update", "static_build", "frame_rates", "clustering", "bake_"];
                !clock.iter().any(|name| key.starts_with(name))
            });
            object.values_mut().for_each(timeless);
        }
        Value::Array(values) => values.iter_mut().for_each(timeless),
        _ => {}
    }
}

#[test]
fn every_other_pose_lies_between_keys() {
    let poses: Vec<_> = MEASURED
        .frames
        .iter()
        .map(|frame| (frame.cache_frame.unwrap(), frame.at_key))
        .collect();
    // Keys 0 to 8, the middles of four equal shares: 1, 3, 5, 7. Frame rate 24: f32 times are off by a rounding.
    for ((found, at_key), (expected, key)) in poses.iter().zip([(1.0, true), (3.5, false), (5.0, true), (7.5, false)]) {
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        assert_eq!(*at_key, key);
    }
    assert_eq!(poses.len(), 4);
}

#[test]
fn counts_repeat() {
    let mut values = [&*MEASURED, &measured()].map(|report| to_value(report).unwrap());
    values.iter_mut().for_each(timeless);
    assert_eq!(values[0], values[1]);
}

#[test]
fn keys_that_scripts_rely_on_are_there_and_positive() {
    let report = to_value(&*MEASURED).unwrap();
    assert_eq!(report["schema"], "restpose.measure.motion.1");
    let positive = |place: &Value, key: &str| {
        let value = place[key].as_f64();
        assert!(value.is_some_and(|x| x > 0.0 && x.is_finite()), "{key}: {}", place[key]);
    };
    for key in [
        "clusters",
        "clustering_seconds",
        "bake_seconds",
        "update_us",
        "static_build_ms",
    ] {
        positive(&report, key);
    }
    assert!(report["rest_frame"].is_u64());
    let seconds = |key: &str| report[key].as_f64().unwrap();
    assert!(
        seconds("clustering_seconds") <= seconds("bake_seconds"),
        "shared clusters count once"
    );
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    for place in std::iter::once(&report).chain(frames) {
        for key in ["clusters", "steps_ratio", "intersections_ratio", "time_ratio"] {
            positive(place, key);
        }
        for kind in ["primary", "wide", "random"] {
            for key in [
                "rays",
                "steps_ratio",
                "intersections_ratio",
                "time_ratio",
                "time_ns_static",
            ] {
                positive(&place[kind], key);
            }
        }
        assert_eq!(place["steps_ratio"], place["primary"]["steps_ratio"]);
        assert_eq!(place["frame_rates"].as_array().unwrap().len(), 2);
    }
    assert_eq!(report["primary"]["rays"], 4 * 24 * 24);
    assert_eq!(report["random"]["rays"], 4 * 300);
}

#[test]
fn poses_are_those_of_their_segments() {
    let segments = &MEASURED.parts[0].segments;
    assert_eq!(segments.len(), 2);
    let all = MEASURED.parts.iter().flat_map(|part| &part.segments);
    let cached = all.map(|segment| segment.clusters).sum::<u64>();
    assert_eq!(
        MEASURED.clusters,
        cached + 1,
        "the stage is a static part without a cache"
    );
    for frame in &MEASURED.frames {
        let at = frame.cache_frame.unwrap();
        let covers = |segment: &&MotionSegment| (segment.key_first as f64..=segment.key_last as f64).contains(&at);
        let segment = &segments[frame.segment.unwrap()];
        assert!(covers(&segment));
        assert_eq!(frame.rest_frame, Some(segment.rest_frame));
        let present = MEASURED
            .parts
            .iter()
            .map(|part| part.segments.iter().find(covers).unwrap());
        assert_eq!(
            u64::from(frame.clusters),
            1 + present.map(|segment| segment.clusters).sum::<u64>()
        );
    }
    assert_eq!(MEASURED.rest_frame, Some(segments[0].rest_frame));
}

#[test]
fn the_clustering_is_shown_from_one_cluster_on() {
    let growth = &MEASURED.growth;
    assert_eq!(growth[0].clusters, 1);
    assert!(growth.len() > 1 && growth.len() <= 5);
    assert!(growth.windows(2).all(|pair| pair[1].clusters == pair[0].clusters + 1));
    assert!(growth[growth.len() - 1].residual < growth[0].residual);
}

#[test]
fn a_filled_picture_is_hit_more_often_than_one_of_all_poses() {
    assert!(MEASURED.primary.hit_fraction > MEASURED.wide.hit_fraction);
}

#[test]
fn page_shows_every_pose_and_the_plots() {
    let page = page(&MEASURED);
    assert_eq!(page.matches("<tr><td>").count(), 3 + MEASURED.frames.len());
    // Both costs against clusters, ratios of camera and random rays, pictures per second on one and two threads.
    assert_eq!(page.matches("<svg").count(), 5);
    assert!(!page.contains("NaN") && !page.contains("inf"));
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |change: fn(&mut MotionSettings), expected: &str| {
        let mut settings = small();
        change(&mut settings);
        match measure_motion(&goose(), &bake(), &settings, &NoProgress).unwrap_err() {
            MeasureError::Setting { name, .. } => assert_eq!(name, expected),
            other => panic!("{expected}: {other}"),
        }
    };
    refused(|settings| settings.poses = 0, "poses");
    refused(|settings| settings.threads.clear(), "number of thread counts");
    refused(|settings| settings.threads.push(0), "threads");
    refused(|settings| settings.picture_side = 0, "picture_side");
    refused(|settings| settings.random_rays = 0, "random_rays");
    refused(|settings| settings.repeats = 0, "repeats");
    refused(|settings| settings.updates = 0, "updates");
}

#[test]
fn what_does_not_move_is_refused() {
    let mut still = goose();
    still.clips.clear();
    let error = measure_motion(&still, &bake(), &small(), &NoProgress).unwrap_err();
    assert!(matches!(error, MeasureError::NoClip { .. }), "{error}");
}
