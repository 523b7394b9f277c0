//! `measure_frame` on samples, with settings that take no time.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{Animation, ImportSettings, import_files},
};
use restpose_formats::write;
use restpose_measure::{
    MeasureError,
    frame::{FrameReport, FrameScene, FrameSettings, Palettes, RayKind, measure_frame, page, strategy_names},
};
use serde_json::{Value, to_value};
use std::{path::Path, sync::LazyLock};

fn sample(names: &[&str]) -> Animation {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
    let paths: Vec<_> = names.iter().map(|name| folder.join(name)).collect();
    import_files(&paths, &ImportSettings::default()).unwrap().animation
}

fn scene(names: &[&str], instances: usize) -> FrameScene {
    FrameScene::imported(&sample(names), 0, instances, BakeSettings::default()).unwrap()
}

fn small() -> FrameSettings {
    FrameSettings {
        threads: vec![1, 2],
        rays: vec![1, 700],
        ray_kinds: RayKind::ALL.to_vec(),
        poses: 2,
        seconds: 0.0,
        turns: 2,
        seed: 5,
        ..FrameSettings::default()
    }
}

fn measured(names: &[&str], instances: usize, settings: &FrameSettings) -> FrameReport {
    measure_frame(&mut scene(names, instances), settings, &NoProgress).unwrap()
}

static CROWD: LazyLock<FrameReport> = LazyLock::new(|| measured(&["walker.glb"], 3, &small()));

fn rows(report: &FrameReport) -> Vec<Value> {
    to_value(report).unwrap()["frames"].as_array().unwrap().clone()
}

#[test]
fn every_strategy_has_a_row_per_threads_kind_and_number_of_rays() {
    let rows = rows(&CROWD);
    for name in strategy_names() {
        let (who, strategy) = name.split_once('-').unwrap();
        for threads in [1, 2] {
            let own = rows.iter().filter(|row| {
                (&row["who"], &row["strategy"], &row["threads"]) == (&who.into(), &strategy.into(), &threads.into())
            });
            let sets: Vec<(&str, u64)> = own
                .map(|row| (row["ray_kind"].as_str().unwrap(), row["rays"].as_u64().unwrap()))
                .collect();
            let expected = [
                ("none", 0),
                ("random", 1),
                ("random", 700),
                ("segment", 1),
                ("segment", 700),
                ("primary", 64),
                ("primary", 24 * 24),
                ("close-up", 64),
                ("close-up", 24 * 24),
            ];
            assert_eq!(sets, expected, "{name}, {threads} threads");
        }
    }
}

#[test]
fn keys_that_scripts_rely_on_are_there() {
    let report = to_value(&*CROWD).unwrap();
    assert_eq!(report["schema"], "restpose.measure.frame.2");
    for row in rows(&CROWD) {
        assert_eq!((&row["scene"], &row["instances"]), (&"walker.glb".into(), &3.into()));
        let positive = |key: &str| row[key].as_f64().is_some_and(|x| x > 0.0);
        for key in ["triangles", "frames", "total_us", "p99_us", "update_us"] {
            assert!(positive(key), "{key}: {row}");
        }
        let [total, p99, update] = ["total_us", "p99_us", "update_us"].map(|key| row[key].as_f64().unwrap());
        assert!(update <= total * 1.5 && total <= p99, "{row}");
        if row["who"] == "restpose" {
            assert_eq!(row["wrong_per_million"], 0.0);
        }
        if row["who"] == "restpose" && row["rays"].as_u64() > Some(64) {
            let counts = &row["counts"];
            for key in ["hit_fraction", "steps", "instances", "bytes_touched"] {
                assert!(counts[key].as_f64().unwrap() > 0.0, "{key}: {row}");
            }
        }
    }
    let glance = &report["glances"][0];
    for key in ["file_bytes", "open_us", "open_seconds_per_gib", "pose_bytes"] {
        assert!(glance[key].as_f64().unwrap() > 0.0, "{key}: {glance}");
    }
    assert!(report["brute_force_rays"].as_u64().unwrap() > 0);
}

#[test]
fn all_but_times_and_memory_repeat() {
    let timeless = |report: &FrameReport| -> Vec<Value> {
        let mut rows = rows(report);
        for row in &mut rows {
            row.as_object_mut()
                .unwrap()
                .retain(|key, _| !key.ends_with("_us") && key != "frames");
        }
        rows
    };
    let again = measured(&["walker.glb"], 3, &small());
    assert_eq!(timeless(&CROWD), timeless(&again));
    // What is counted does not depend on threads either.
    let counts = |threads: u64| -> Vec<Value> {
        let rows = rows(&CROWD).into_iter().filter(|row| row["threads"] == threads);
        rows.map(|row| row["counts"].clone()).collect()
    };
    assert_eq!(counts(1), counts(2));
}

#[test]
fn given_palettes_hit_the_same() {
    let given = FrameSettings {
        palettes: Palettes::Given,
        ..small()
    };
    let counts = |report: &FrameReport| -> Vec<Value> {
        let rows = rows(report);
        rows.iter().map(|row| row["counts"]["hit_fraction"].clone()).collect()
    };
    let given = measured(&["walker.glb"], 3, &given);
    assert_eq!(counts(&given), counts(&CROWD));
}

#[test]
fn vertex_caches_and_baked_files_are_measured() {
    let settings = FrameSettings {
        threads: vec![1],
        ray_kinds: vec![RayKind::Random],
        ..small()
    };
    let goose = measured(&["goose.obj", "goose.pc2"], 2, &settings);
    assert!(goose.frames.iter().any(|row| row.rays == 700));

    let baked = bake(&sample(&["walker.glb"]), &BakeSettings::default(), &NoProgress).unwrap();
    let bytes = write(&baked.model).unwrap();
    let mut scene = FrameScene::baked("walker.rpose".to_owned(), bytes, 1).unwrap();
    let from_file = measure_frame(&mut scene, &settings, &NoProgress).unwrap();
    assert_eq!(from_file.frames[0].scene, "walker.rpose");
    assert_eq!(from_file.frames[0].triangles * 3, CROWD.frames[0].triangles);
}

#[test]
fn page_has_a_plot_per_kind_and_thread_count_and_every_row() {
    let page = page(&CROWD);
    assert_eq!(page.matches("<svg").count(), 4 * 2);
    let without = CROWD.frames.iter().filter(|row| row.rays == 0).count();
    let expected = CROWD.frames.len() + without + CROWD.glances.len() + CROWD.crossovers.len();
    assert_eq!(page.matches("<tr><td>").count(), expected);
    assert!(!page.contains("NaN"));
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let refused = |change: fn(&mut FrameSettings)| {
        let mut settings = small();
        change(&mut settings);
        measure_frame(&mut scene(&["walker.glb"], 1), &settings, &NoProgress).unwrap_err()
    };
    let setting = |change: fn(&mut FrameSettings), expected: &str| match refused(change) {
        MeasureError::Setting { name, .. } => assert_eq!(name, expected),
        other => panic!("{expected}: {other}"),
    };
    setting(|settings| settings.threads.push(0), "threads");
    setting(|settings| settings.rays.push(0), "rays");
    setting(|settings| settings.poses = 0, "poses");
    setting(|settings| settings.turns = 0, "turns");
    let error = refused(|settings| settings.strategies.push("guess".to_owned()));
    assert!(matches!(error, MeasureError::UnknownStrategy { .. }), "{error}");
    let error = refused(|settings| settings.strategies.clear());
    assert!(matches!(error, MeasureError::NoStrategy { .. }), "{error}");
    for instances in [0, (1 << 20) + 1] {
        let refused = FrameScene::imported(&sample(&["walker.glb"]), 0, instances, BakeSettings::default());
        let error = refused.err().unwrap();
        assert!(
            matches!(error, MeasureError::Setting { name: "instances", .. }),
            "{error}"
        );
    }
}
