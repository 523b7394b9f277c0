//! `measure_poses` on a sample, with settings that take no time.

use restpose_bake::{
    NoProgress,
    import::{Animation, import},
};
use restpose_formats::TreeKind;
use restpose_measure::{
    MeasureError,
    poses::{PosesReport, PosesSettings, measure_poses, page},
};
use serde_json::{Value, to_value};
use std::{path::Path, sync::LazyLock};

fn tentacle() -> Animation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes/tentacle.gltf");
    import(&path).unwrap().animation
}

fn small() -> PosesSettings {
    PosesSettings {
        rays: 150,
        poses: 2,
        levels: 1,
        clip: None,
        repeats: 1,
        seed: 5,
        ..PosesSettings::default()
    }
}

static MEASURED: LazyLock<PosesReport> = LazyLock::new(|| measure_poses(&tentacle(), &small(), &NoProgress).unwrap());

fn rows(table: &str) -> Vec<Value> {
    to_value(&*MEASURED).unwrap()[table].as_array().unwrap().clone()
}

/// The numbers that no clock has touched.
fn timeless(value: &mut Value) {
    match value {
        Value::Object(object) => {
            let clock = ["commit_us", "check_", "mrays_per_s", "relative_speed", "frames_per_s"];
            object.retain(|key, _| !key.ends_with("_seconds") && !clock.iter().any(|name| key.starts_with(name)));
            object.values_mut().for_each(timeless);
        }
        Value::Array(values) => values.iter_mut().for_each(timeless),
        _ => {}
    }
}

/// The values of these keys, as one text.
fn cells(row: &Value, keys: &[&str]) -> String {
    keys.iter()
        .map(|key| row[key].to_string())
        .collect::<Vec<_>>()
        .join(" ")
        .replace('"', "")
}

#[test]
fn counts_repeat() {
    let settings = PosesSettings {
        rays: 40,
        poses: 1,
        levels: 0,
        tree: TreeKind::Kd,
        ..small()
    };
    let measured = || {
        let mut report = to_value(measure_poses(&tentacle(), &settings, &NoProgress).unwrap()).unwrap();
        timeless(&mut report);
        report
    };
    let first = measured();
    assert_eq!(measured(), first);
    for row in first["bounds"].as_array().unwrap() {
        assert!(row["box_tests"].as_f64().unwrap() > 0.0 && row["triangles_per_leaf"].as_f64().unwrap() > 1.0);
    }
}

#[test]
fn every_pose_space_stands_by_both_bounds() {
    let rows = rows("pose_spaces");
    let found: Vec<String> = rows
        .iter()
        .map(|row| cells(row, &["pose_space", "bounds", "rays"]))
        .collect();
    let mut expected = Vec::new();
    for space in ["one clip", "clips", "limits", "arbitrary"] {
        for bounds in ["sampled", "envelope"] {
            for rays in ["primary", "random"] {
                expected.push(format!("{space} {bounds} {rays}"));
            }
        }
    }
    assert_eq!(found, expected);
    assert_eq!(rows[0]["area_ratio"], 1.0);
    let area = |row: usize| rows[row]["fuzzy_box_area"].as_f64().unwrap();
    assert!(area(12) > area(0), "more poses, larger boxes");
    assert!(area(2) >= area(0), "what holds between samples holds at samples");
}

#[test]
fn every_bound_stands_in_every_kind_of_pose_at_every_tessellation() {
    let rows = rows("bounds");
    let found: Vec<String> = rows
        .iter()
        .map(|row| cells(row, &["subdivisions", "poses", "envelopes", "rays"]))
        .collect();
    let mut expected = Vec::new();
    for subdivisions in 0..2 {
        for poses in ["clip", "blend", "ragdoll"] {
            for envelopes in ["null", "1", "4", "16", "64", "1024"] {
                for rays in ["primary", "random"] {
                    expected.push(format!("{subdivisions} {poses} {envelopes} {rays}"));
                }
            }
        }
    }
    assert_eq!(found, expected);
    let first = &rows[0];
    let half = rows.len() / 2;
    assert_eq!(
        rows[half]["triangles"].as_u64(),
        first["triangles"].as_u64().map(|count| 4 * count)
    );
    for row in &rows {
        let is_sampled = row["bounds"] == "sampled";
        let outside = row["clusters_outside"].as_u64().unwrap();
        assert_eq!(is_sampled, row["envelopes"].is_null());
        match row["poses"].as_str().unwrap() {
            "ragdoll" => assert_eq!(outside == 0, is_sampled, "{row}"),
            "clip" => assert_eq!(outside, 0, "{row}"),
            _ => {}
        }
        if !is_sampled {
            assert_eq!(cells(row, &["missed_per_million", "wrong_per_million"]), "0.0 0.0");
        }
        assert_eq!(row["pose_count"], 2);
        let asked = 2 * if row["rays"] == "primary" { 12 * 12 } else { 150 };
        let fewest = if row["poses"] == "ragdoll" { 2 * 9 } else { asked };
        let count = row["ray_count"].as_u64().unwrap();
        assert!((fewest..=asked).contains(&count), "{row}");
    }
}

#[test]
fn sampled_boxes_lose_hits_far_outside_their_poses_and_envelopes_do_not() {
    let lost = rows("bounds")
        .iter()
        .filter(|row| row["poses"] == "ragdoll" && row["bounds"] == "sampled")
        .map(|row| row["missed_per_million"].as_f64().unwrap() + row["wrong_per_million"].as_f64().unwrap())
        .sum::<f64>();
    assert!(lost > 0.0, "a measurement that finds no loss here finds none anywhere");
}

#[test]
fn fewer_samples_make_smaller_boxes() {
    let rows = rows("accuracy");
    let steps: Vec<Option<f64>> = rows.iter().map(|row| row["sample_step_seconds"].as_f64()).collect();
    let expected = [
        Some(1.0 / 60.0),
        Some(1.0 / 30.0),
        Some(1.0 / 15.0),
        Some(0.125),
        Some(0.25),
        None,
        None,
        None,
        None,
    ];
    assert_eq!(steps, expected.iter().flat_map(|step| [*step; 2]).collect::<Vec<_>>());
    let number = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    for row in (0..8).step_by(2) {
        assert!(number(row + 2, "samples") < number(row, "samples"));
    }
    assert!(number(8, "fuzzy_box_area") < number(0, "fuzzy_box_area"));
    assert_eq!(rows[0]["keys_sampled"], true);
    assert_eq!(rows[2]["keys_sampled"], false);
}

#[test]
fn keys_that_scripts_rely_on_are_there_and_positive() {
    let report = to_value(&*MEASURED).unwrap();
    assert_eq!(report["schema"], "restpose.measure.poses.1");
    assert_eq!(report["tessellations"].as_array().unwrap().len(), 2 * 6);
    for table in ["pose_spaces", "bounds", "tessellations", "accuracy"] {
        for row in report[table].as_array().unwrap() {
            assert_eq!(row["scene"], "tentacle.gltf");
            // Wide trees have a triangle per leaf, whose box is tested with others.
            assert_eq!(
                (&row["triangles_per_leaf"], &row["box_tests"]),
                (&1.0.into(), &0.0.into())
            );
            for key in [
                "triangles",
                "samples",
                "area_ratio",
                "triangles_per_leaf",
                "bytes",
                "bake_seconds",
                "ray_count",
                "hit_fraction",
                "steps",
                "triangle_tests",
                "mrays_per_s",
                "relative_speed",
            ] {
                let value = row[key].as_f64();
                assert!(
                    value.is_some_and(|x| x > 0.0 && x.is_finite()),
                    "{table} {key}: {}",
                    row[key]
                );
            }
        }
    }
    for row in report["tessellations"].as_array().unwrap() {
        assert!(row["frames_per_s"].as_f64().unwrap() > 0.0 && row["sampling_seconds"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn page_shows_every_row_and_the_plots() {
    let report = &*MEASURED;
    let page = page(report);
    let rows = [
        report.pose_spaces.len(),
        report.bounds.len(),
        report.tessellations.len(),
        report.accuracy.len(),
        report.thesis_pose_spaces.len(),
        report.thesis_tessellations.len(),
    ];
    assert_eq!(page.matches("<tr><td>").count(), rows.iter().sum::<usize>());
    assert_eq!(page.matches("<svg").count(), 6);
    assert!(!page.contains("NaN"));
}

#[test]
fn scenes_follow_each_other() {
    let mut both = MEASURED.clone();
    both.append(MEASURED.clone());
    assert_eq!(both.bounds.len(), 2 * MEASURED.bounds.len());
    assert_eq!(both.accuracy.len(), 2 * MEASURED.accuracy.len());
    assert_eq!(both.brute_force_rays, 2 * MEASURED.brute_force_rays);
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |change: fn(&mut PosesSettings), expected: &str| {
        let mut settings = small();
        change(&mut settings);
        match measure_poses(&tentacle(), &settings, &NoProgress).unwrap_err() {
            MeasureError::Setting { name, .. } => assert_eq!(name, expected),
            other => panic!("{expected}: {other}"),
        }
    };
    refused(|settings| settings.rays = 0, "rays");
    refused(|settings| settings.rays = u32::MAX, "rays");
    refused(|settings| settings.poses = 0, "poses");
    refused(|settings| settings.levels = 6, "levels");
    refused(|settings| settings.repeats = 0, "repeats");
}

#[test]
fn a_clip_that_is_not_there_and_a_source_without_clips_are_refused() {
    let settings = PosesSettings {
        clip: Some("swim".to_owned()),
        ..small()
    };
    let error = measure_poses(&tentacle(), &settings, &NoProgress).unwrap_err();
    assert!(
        matches!(error, MeasureError::Bake(_)) && error.to_string().contains("swim"),
        "{error}"
    );
    let mut still = tentacle();
    still.clips.clear();
    let error = measure_poses(&still, &small(), &NoProgress).unwrap_err();
    assert!(matches!(error, MeasureError::NoClip { .. }), "{error}");
}
