//! `measure builders` as a user meets it.

use crate::{
    fixture::{door, folder},
    run::{files, restpose},
};

/// Settings that take no time.
const LEAST: [&str; 12] = [
    "--repeats",
    "1",
    "--thread-counts",
    "1",
    "--picture-side",
    "8",
    "--random-rays",
    "20",
    "--shuffled",
    "off",
    "--animation-frames",
    "2",
];

#[test]
fn tables_are_printed_and_name_every_scene_and_builder() {
    let folder = folder();
    door(folder.path());
    let scenes = [
        "measure",
        "builders",
        "door.gltf",
        "--generated",
        "regular=40",
        "--generated",
        "uneven=7",
    ];
    let run = restpose(folder.path(), scenes.iter().chain(&LEAST)).succeeded();
    for words in [
        "Exact and fast builders",
        "From frame to frame",
        "Builds: ",
        "door.gltf",
        "regular=40",
        "uneven=7",
        "bvh-sweep",
        "bvh-streamed-fast",
        "bvh-streamed-thesis",
        "kd-sweep",
    ] {
        assert!(run.stdout.contains(words), "{words}: {run:?}");
    }
    assert!(!run.stdout.contains("NaN") && !run.stdout.contains("inf"), "{run:?}");
}

#[test]
fn only_chosen_builders_are_measured() {
    let folder = folder();
    let chosen = [
        "measure",
        "builders",
        "--generated",
        "uneven=30",
        "--json",
        "--builder",
        "bvh-median",
        "--builder",
        "bvh-grid",
    ];
    let report = restpose(folder.path(), chosen.iter().chain(&LEAST)).succeeded().json();
    let rows = report["builds"].as_array().expect("rows");
    let found: Vec<_> = rows
        .iter()
        .map(|row| (row["builder"].as_str(), row["reference"].as_str()))
        .collect();
    // The order of the list, whatever that of the options.
    let reference = Some("bvh-median");
    assert_eq!(found, [(Some("bvh-median"), reference), (Some("bvh-grid"), reference)]);
}

#[test]
fn what_cannot_be_measured_is_refused_before_work() {
    let folder = folder();
    door(folder.path());
    let cases: [(&[&str], i32, &str); 11] = [
        (&[], 1, "required arguments"),
        (
            &["--generated", "flat=3"],
            1,
            "expected KIND=TRIANGLES, KIND regular or uneven, TRIANGLES 1 to 100000000",
        ),
        (&["--generated", "regular=0"], 1, "TRIANGLES 1 to 100000000"),
        (&["--generated", "regular=100000001"], 1, "TRIANGLES 1 to 100000000"),
        (&["door.gltf", "--builder", "octree"], 1, "possible values: bvh-sweep"),
        (&["door.gltf", "--seconds=-1"], 1, "expected a number from 0 to 1000000"),
        (
            &["door.gltf", "--builder", "kd-tracked", "--builder", "bvh-sweep"],
            1,
            "another of kd trees",
        ),
        (&["none.gltf"], 2, "none.gltf: cannot read"),
        (&["+none.pc2"], 2, "+none.pc2: cannot read"),
        (&["a+b/none.obj+none.pc2"], 2, "a+b/none.obj: cannot read"),
        (&["door.gltf+none.pc2"], 2, "none.pc2: cannot read"),
    ];
    let before = files(folder.path());
    for (arguments, code, words) in cases {
        let run = restpose(
            folder.path(),
            ["measure", "builders", "-o", "out"].iter().chain(arguments),
        );
        assert_eq!(run.code, code, "{arguments:?}: {run:?}");
        assert!(run.stderr.contains(words), "{arguments:?}: {run:?}");
        assert_eq!(files(folder.path()), before, "{arguments:?}");
    }
}
