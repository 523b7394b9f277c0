//! `measure_builders` on small scenes, with settings that take no time.

use restpose_bake::{NoProgress, import::import};
use restpose_measure::{
    MeasureError, TextRow,
    builders::{
        BuilderScene, BuildersReport, BuildersSettings, Generated, GeneratedKind, builder_names, measure_builders, page,
    },
};
use serde_json::{Value, to_value};
use std::{path::Path, sync::LazyLock};

fn scene(kind: GeneratedKind, triangles: usize) -> BuilderScene {
    BuilderScene::generated(Generated { kind, triangles }, 3)
}

fn small() -> BuildersSettings {
    BuildersSettings {
        threads: vec![1, 2],
        repeats: 2,
        picture_side: 24,
        random_rays: 300,
        seed: 3,
        ..BuildersSettings::default()
    }
}

static MEASURED: LazyLock<BuildersReport> = LazyLock::new(|| {
    let mut report = measure_builders(&scene(GeneratedKind::Uneven, 2000), &small(), &NoProgress).unwrap();
    report.append(measure_builders(&scene(GeneratedKind::Regular, 500), &small(), &NoProgress).unwrap());
    report
});

fn rows(report: &BuildersReport) -> Vec<Value> {
    to_value(report).unwrap()["builds"].as_array().unwrap().clone()
}

#[test]
fn every_builder_has_a_row_per_scene_order_and_number_of_threads() {
    let rows = rows(&MEASURED);
    for scene in ["uneven=2000", "regular=500"] {
        for shuffled in [false, true] {
            for builder in builder_names() {
                // Of these there are rows for animations only.
                if builder.starts_with("kd-tracked") {
                    continue;
                }
                let own: Vec<&Value> = rows
                    .iter()
                    .filter(|row| row["scene"] == scene && row["shuffled"] == shuffled && row["builder"] == builder)
                    .collect();
                let threads: Vec<u64> = own.iter().map(|row| row["threads"].as_u64().unwrap()).collect();
                let peer = own[0]["peer"] == true;
                assert!(
                    peer || threads == [1] || threads == [1, 2],
                    "{scene} {builder}: {threads:?}"
                );
                for row in own {
                    for key in [
                        "seconds",
                        "first_seconds",
                        "mtris_per_s",
                        "sah_cost",
                        "sah_relative",
                        "render_relative",
                    ] {
                        assert!(row[key].as_f64().unwrap() > 0.0, "{builder} {key}");
                    }
                    assert_eq!(row["builds"], 2);
                }
            }
        }
    }
}

#[test]
fn references_are_the_first_of_their_kind_and_relative_to_themselves() {
    for row in rows(&MEASURED) {
        let reference = if row["tree"] == "kd" { "kd-sweep" } else { "bvh-sweep" };
        assert_eq!(row["reference"], reference);
        if row["builder"] == reference {
            for key in [
                "speedup",
                "scaling",
                "sah_relative",
                "render_relative",
                "random_render_relative",
            ] {
                assert_eq!(row[key], 1.0, "{key}");
            }
        }
    }
    // What the papers find: quality of binned trees is near that of exact ones, of medians below.
    let quality = |builder: &str| {
        let rows = rows(&MEASURED);
        let row = rows
            .iter()
            .find(|row| row["scene"] == "uneven=2000" && row["builder"] == builder);
        row.unwrap()["sah_relative"].as_f64().unwrap()
    };
    assert!(quality("bvh-binned") > 0.8);
    assert!(quality("bvh-median") < quality("bvh-binned"));
}

#[test]
fn all_but_times_repeat() {
    let timeless = || {
        let settings = BuildersSettings {
            shuffled: false,
            ..small()
        };
        let report = measure_builders(&scene(GeneratedKind::Uneven, 700), &settings, &NoProgress).unwrap();
        let keys = [
            "nodes",
            "references",
            "depth",
            "sah_cost",
            "primary_steps",
            "primary_tests",
            "random_steps",
            "random_tests",
        ];
        let rows = rows(&report);
        let own = rows.iter().filter(|row| row["peer"] == false);
        own.map(|row| keys.map(|key| row[key].to_string())).collect::<Vec<_>>()
    };
    assert_eq!(timeless(), timeless());
}

#[test]
fn rays_hit_and_are_compared_with_brute_force() {
    for row in rows(&MEASURED) {
        assert!(row["primary_hit_fraction"].as_f64().unwrap() > 0.2, "{row}");
        assert!(row["random_hit_fraction"].as_f64().unwrap() > 0.02, "{row}");
    }
    // Two scenes in two orders, two kinds of rays.
    assert!(MEASURED.brute_force_rays >= 2 * 2 * 2 * 16);
}

#[test]
fn orders_stand_side_by_side() {
    let cells: Vec<[String; 11]> = MEASURED.orders().iter().map(TextRow::cells).collect();
    let references = ["bvh-sweep", "kd-sweep"];
    let static_ones = builder_names()
        .into_iter()
        .filter(|name| !name.starts_with("kd-tracked"));
    let expected = static_ones.filter(|name| !references.contains(name));
    let found = cells
        .iter()
        .filter(|row| row[0] == "regular=500")
        .map(|row| row[3].as_str());
    assert!(found.eq(expected), "{cells:?}");
    assert!(cells.iter().flatten().all(|cell| cell != "-"), "{cells:?}");

    let settings = BuildersSettings {
        shuffled: false,
        ..small()
    };
    let report = measure_builders(&scene(GeneratedKind::Regular, 30), &settings, &NoProgress).unwrap();
    for row in report.orders() {
        let cells = row.cells();
        assert_eq!([5, 7, 9].map(|column| cells[column].as_str()), ["-"; 3], "{cells:?}");
    }
}

#[test]
fn builders_that_follow_an_animation_stand_beside_exact_ones() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes/walker.glb");
    let walker = BuilderScene::imported(&import(&path).unwrap().animation, 6).unwrap();
    let report = to_value(measure_builders(&walker, &small(), &NoProgress).unwrap()).unwrap();
    let (animations, frames) = (
        report["animations"].as_array().unwrap(),
        report["animation_frames"].as_array().unwrap(),
    );
    assert_eq!(frames.len(), 6 * animations.len());
    let refit = animations.iter().find(|row| row["builder"] == "bvh-refit").unwrap();
    assert_eq!(
        (&refit["frames"], &refit["reference"]),
        (&Value::from(6), &Value::from("bvh-sweep"))
    );
    // A character that walks is refitted well, and not for nothing.
    let least = refit["sah_relative_least"].as_f64().unwrap();
    assert!((0.3..1.0).contains(&least), "{least}");
    // What is foreseen is counted, and nothing is in a first frame.
    for builder in ["kd-tracked", "kd-tracked-paper"] {
        let row = animations.iter().find(|row| row["builder"] == builder).unwrap();
        assert!(row["tracked_fraction"].as_f64().unwrap() > 0.0, "{row}");
        assert!((0.0..0.5).contains(&row["prediction_error"].as_f64().unwrap()), "{row}");
        let first = frames.iter().find(|row| row["builder"] == builder).unwrap();
        assert_eq!(first["tracked_fraction"], 0.0);
    }
    for row in frames {
        let relative = row["sah_relative"].as_f64().unwrap();
        assert!(relative > 0.3 && row["seconds"].as_f64().unwrap() > 0.0, "{row}");
    }
    assert!(!to_value(&*MEASURED).unwrap()["theirs"].as_array().unwrap().is_empty());
}

#[test]
fn the_page_has_plots_and_tables_and_no_number_that_is_none() {
    let page = page(&MEASURED);
    // Build rates; per scene two kinds of trees and threads.
    assert_eq!(page.matches("<svg").count(), 1 + 2 * 3);
    for text in ["uneven=2000", "bvh-hybrid", "What the papers report", "BOEING 777"] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("NaN") && !page.contains(">inf<"), "{page}");
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |settings: BuildersSettings| {
        let scene = scene(GeneratedKind::Regular, 20);
        measure_builders(&scene, &settings, &NoProgress)
            .unwrap_err()
            .to_string()
    };
    let unknown = refused(BuildersSettings {
        builders: vec!["octree".to_owned()],
        ..small()
    });
    assert!(
        unknown.starts_with("no builder \"octree\"; known: bvh-sweep"),
        "{unknown}"
    );
    let settings = [
        (
            BuildersSettings {
                builders: Vec::new(),
                ..small()
            },
            "number of builders is 0",
        ),
        (
            BuildersSettings {
                threads: Vec::new(),
                ..small()
            },
            "number of thread counts is 0",
        ),
        (
            BuildersSettings {
                threads: vec![0],
                ..small()
            },
            "threads is 0",
        ),
        (BuildersSettings { repeats: 0, ..small() }, "repeats is 0"),
        (
            BuildersSettings {
                picture_side: 8193,
                ..small()
            },
            "picture_side is 8193",
        ),
        (
            BuildersSettings {
                random_rays: 0,
                ..small()
            },
            "random_rays is 0",
        ),
    ];
    for (settings, message) in settings {
        assert!(refused(settings).starts_with(message), "{message}");
    }
}

#[test]
fn a_source_without_triangles_is_refused() {
    let empty = restpose_bake::import::Animation::default();
    let scene = BuilderScene::imported(&empty, 5).unwrap();
    let refused = measure_builders(&scene, &small(), &NoProgress);
    assert!(matches!(refused, Err(MeasureError::Boxes { .. })), "{refused:?}");
}
