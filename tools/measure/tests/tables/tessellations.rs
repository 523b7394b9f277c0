//! `measure_tessellations` on a sample, with settings that take no time.

use restpose_bake::{
    NoProgress,
    import::{Animation, import},
};
use restpose_measure::{
    MeasureError,
    tessellations::{TessellationsReport, TessellationsSettings, measure_tessellations, page},
};
use serde_json::{Value, to_value};
use std::{path::Path, sync::LazyLock};

fn walker() -> Animation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes/walker.glb");
    import(&path).unwrap().animation
}

fn small() -> TessellationsSettings {
    TessellationsSettings {
        subdivide_max: 1,
        threads: vec![1, 2],
        frames: 2,
        picture_side: 24,
        random_rays: 300,
        repeats: 1,
        updates: 1,
        seed: 5,
        ..TessellationsSettings::default()
    }
}

fn measured() -> TessellationsReport {
    measure_tessellations(&walker(), &small(), &NoProgress).unwrap()
}

static MEASURED: LazyLock<TessellationsReport> = LazyLock::new(measured);

/// The row's numbers that no clock has touched.
fn timeless(mut row: Value) -> Value {
    let object = row.as_object_mut().unwrap();
    object.retain(|key, _| {
        !key.starts_with("update") && !key.starts_with("mrays") && key != "bake_seconds" && key != "static_build_ms"
    });
    row
}

#[test]
fn rows_go_by_subdivisions_then_threads_and_their_counts_repeat() {
    let rows =
        |report: &TessellationsReport| -> Vec<Value> { report.rows.iter().map(|row| to_value(row).unwrap()).collect() };
    let first = &*MEASURED;
    let order: Vec<_> = first.rows.iter().map(|row| (row.subdivisions, row.threads)).collect();
    assert_eq!(order, [(0, 1), (0, 2), (1, 1), (1, 2)]);
    assert_eq!(first.rows[2].triangles, 4 * first.rows[0].triangles);

    let again = measured();
    for (a, b) in rows(first).into_iter().zip(rows(&again)) {
        assert_eq!(timeless(a), timeless(b));
    }
    let rows = rows(first);
    for pair in rows.chunks(2) {
        let without_threads = |row: &Value| {
            let mut row = timeless(row.clone());
            row.as_object_mut().unwrap().remove("threads");
            row
        };
        assert_eq!(without_threads(&pair[0]), without_threads(&pair[1]));
    }
}

#[test]
fn keys_that_scripts_rely_on_are_there_and_positive() {
    let report = to_value(&*MEASURED).unwrap();
    assert_eq!(report["schema"], "restpose.measure.tessellations.2");
    assert_eq!(report["source"], "walker.glb");
    for row in report["rows"].as_array().unwrap() {
        for key in [
            "triangles",
            "threads",
            "update_us",
            "update_p99_us",
            "mrays_primary",
            "mrays_random",
            "mrays_primary_static",
            "mrays_random_static",
            "mrays_random_ratio",
            "steps_per_ray",
            "tests_per_ray",
            "clusters_per_ray",
            "steps_per_ray_primary",
            "tests_per_ray_random_static",
            "hit_fraction_primary",
            "hit_fraction_random",
            "bake_seconds",
            "file_bytes",
            "tree_nodes",
            "tree_references",
            "fuzzy_box_area",
            "static_box_area",
            "static_build_ms",
        ] {
            let value = row[key].as_f64();
            assert!(value.is_some_and(|x| x > 0.0 && x.is_finite()), "{key}: {}", row[key]);
        }
        assert_eq!(row["tests_per_ray"], row["tests_per_ray_random"]);
        assert_eq!(row["rays_primary"], 2 * 24 * 24);
        assert_eq!(row["rays_random"], 2 * 300);
        assert_eq!(
            row["clusters_per_ray_random_static"].as_f64().map(|x| x <= 1.0),
            Some(true)
        );
    }
}

#[test]
fn page_shows_every_row_and_a_plot_per_thread_count() {
    let report = &*MEASURED;
    let page = page(report);
    assert_eq!(page.matches("<tr><td>").count(), report.rows.len());
    assert_eq!(page.matches("<svg").count(), 3);
    assert!(!page.contains("NaN") && !page.contains("inf"));
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |change: fn(&mut TessellationsSettings), expected: &str| {
        let mut settings = small();
        change(&mut settings);
        match measure_tessellations(&walker(), &settings, &NoProgress).unwrap_err() {
            MeasureError::Setting { name, .. } => assert_eq!(name, expected),
            other => panic!("{expected}: {other}"),
        }
    };
    refused(|settings| settings.subdivide_max = 6, "subdivide_max");
    refused(|settings| settings.threads.clear(), "number of thread counts");
    refused(|settings| settings.threads.push(0), "threads");
    refused(|settings| settings.frames = 0, "frames");
    refused(|settings| settings.picture_side = 0, "picture_side");
    refused(|settings| settings.random_rays = 0, "random_rays");
    refused(|settings| settings.repeats = 0, "repeats");
    refused(|settings| settings.updates = 0, "updates");
}

#[test]
fn more_triangles_than_memory_are_refused_before_they_are_made() {
    let mut animation = walker();
    let triangles = &mut animation.meshes[0].primitives[0].triangles;
    triangles.resize(40_000, [0, 1, 2]);
    let settings = TessellationsSettings {
        subdivide_max: 5,
        ..small()
    };
    let error = measure_tessellations(&animation, &settings, &NoProgress).unwrap_err();
    assert!(
        matches!(error, MeasureError::TooManyTriangles { subdivisions: 5, .. }),
        "{error}"
    );
}
