use crate::{
    fixture::{folder, sample},
    flag::{FRAMES, SEGMENTED, baked_flag, flag, mdd, model, outgrown_flag, sequence},
    run::restpose,
};
use std::{fs, path::Path};

/// Bakes to `new.rpose` and verifies that file against the same source; gives the object that the bake printed.
#[track_caller]
fn bake(folder: &Path, inputs: &[&str], options: &[&str]) -> serde_json::Value {
    let bake = [&["bake", "-o", "new.rpose", "--json"], inputs, options].concat();
    let json = restpose(folder, bake).succeeded().json();
    let verify = [&["verify", "new.rpose", "--rays", "2000", "--json"], inputs].concat();
    let verified = restpose(folder, verify).succeeded().json();
    assert!(verified["hits"].as_u64().is_some_and(|hits| hits > 200), "{verified}");
    json
}

#[test]
fn every_kind_of_input_is_baked_and_verified() {
    let folder = folder();
    let folder = folder.path();
    flag(folder);
    mdd(folder);
    sequence(folder);
    let frames: Vec<String> = (0..FRAMES).map(|frame| format!("frames/f{frame}.obj")).collect();
    let frames: Vec<&str> = frames.iter().map(String::as_str).collect();
    let inputs: [&[&str]; 4] = [
        &["flag.obj", "flag.pc2"],
        &["flag.obj", "flag.mdd"],
        &["frames"],
        &frames,
    ];
    for inputs in inputs {
        let json = bake(folder, inputs, &["--rays-per-frame", "0"]);
        assert_eq!(json["inputs"].as_array().map(Vec::len), Some(inputs.len()));
        for (part, name, class) in [(0, "cloth", "keyframed"), (1, "stone", "rigid")] {
            let part = &json["parts"][part];
            assert_eq!((&part["name"], &part["class"]), (&name.into(), &class.into()), "{part}");
            assert_eq!(part["cache"]["keys"], FRAMES);
        }
    }
    let json = bake(folder, &["flag.obj"], &[]);
    assert_eq!(json["parts"][0]["class"], "static");
    assert!(json["parts"][0]["cache"].is_null());
}

#[test]
fn mesh_and_cache_come_in_any_order() {
    let folder = folder();
    flag(folder.path());
    let bytes = |inputs: &[&str]| {
        bake(folder.path(), inputs, &[]);
        fs::read(folder.path().join("new.rpose")).expect("just baked")
    };
    assert_eq!(bytes(&["flag.obj", "flag.pc2"]), bytes(&["flag.pc2", "flag.obj"]));
}

#[test]
fn verify_reads_the_frames_that_were_baked() {
    let folder = folder();
    flag(folder.path());
    sequence(folder.path());
    for inputs in [&["flag.obj", "flag.pc2"][..], &["frames"]] {
        let json = bake(folder.path(), inputs, &["--frame-rate", "10", "--frames", "1-3/2"]);
        assert_eq!(json["parts"][0]["cache"]["keys"], 2);
        let info = restpose(folder.path(), ["info", "new.rpose", "--json"])
            .succeeded()
            .json();
        let clip = &info["clips"][0];
        // Times are 32-bit numbers.
        let seconds = |key: &str| clip[key].as_f64().map(|seconds| (seconds * 1e6).round());
        assert_eq!(
            (seconds("start_seconds"), seconds("end_seconds")),
            (Some(1e5), Some(3e5)),
            "{clip}"
        );
        assert_eq!(info["options"]["frame_step"], "2", "{info}");
    }
}

#[test]
fn an_import_option_that_cannot_be_read_back_is_told() {
    let folder = folder();
    baked_flag(folder.path(), &[]);
    let path = folder.path().join("flag.rpose");
    let mut model = model(&path);
    for (name, value) in &mut model.meta.options {
        if name == "frame_step" {
            *value = "some".to_owned();
        }
    }
    fs::write(&path, restpose_formats::write(&model).expect("options are free text")).expect("room");
    let run = restpose(folder.path(), ["verify", "flag.rpose", "flag.obj", "flag.pc2"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(
        run.stderr.contains("flag.rpose: its option frame_step is \"some\""),
        "{run:?}"
    );
}

#[test]
fn if_changed_looks_at_every_file_and_option() {
    let folder = folder();
    flag(folder.path());
    let unchanged = |options: &[&str]| {
        let start = [
            "bake",
            "flag.obj",
            "flag.pc2",
            "-o",
            "flag.rpose",
            "--if-changed",
            "--json",
        ];
        restpose(folder.path(), start.iter().chain(options)).succeeded().json()["skipped"] == true
    };
    let options: [&[&str]; 12] = [
        &["--frame-rate", "30"],
        &["--frames", "0-4"],
        &["--position-error", "0.01"],
        &["--max-clusters", "2"],
        &["--cluster-threshold", "0.5"],
        &["--iteration-threshold", "0.5"],
        &["--max-iterations", "2"],
        &["--rest-step", "2"],
        &["--principal-axes", "off"],
        &["--segments", "2"],
        &["--size-worth", "3"],
        &["--rays-per-frame", "5"],
    ];
    assert!(!unchanged(&[]));
    let (file, plain) = (folder.path().join("flag.rpose"), folder.path().join("plain.rpose"));
    fs::copy(&file, &plain).expect("room");
    for options in options {
        fs::copy(&plain, &file).expect("room");
        assert!(!unchanged(options), "{options:?}");
        assert!(unchanged(options), "{options:?}");
    }
    for name in ["flag.obj", "flag.pc2"] {
        fs::copy(&plain, &file).expect("room");
        let path = folder.path().join(name);
        let whole = fs::read(&path).expect("just written");
        let mut bytes = whole.clone();
        // A digit of a point; a bit in the last number.
        let place = if name == "flag.obj" { 2 } else { bytes.len() - 4 };
        bytes[place] ^= 1;
        fs::write(&path, bytes).expect("room");
        assert!(!unchanged(&[]), "{name}");
        assert!(unchanged(&[]), "{name}");
        fs::write(&path, whole).expect("room");
    }
}

#[test]
fn the_position_error_trades_bytes_for_accuracy() {
    let folder = folder();
    flag(folder.path());
    let cache = |error: &str| {
        let options = ["--rays-per-frame", "0", "--position-error", error];
        let json = bake(folder.path(), &["flag.obj", "flag.pc2"], &options);
        let number = |key: &str| json["parts"][0]["cache"][key].as_f64().expect("a number");
        (number("position_error"), number("bytes_per_vertex_key"))
    };
    let (exact, coarse) = (cache("0"), cache("0.01"));
    assert_eq!(exact.0, 0.0);
    assert!(coarse.0 > 0.0 && coarse.0 <= 0.01, "{coarse:?}");
    assert!(coarse.1 < exact.1 && exact.1 >= 12.0, "{exact:?} {coarse:?}");
}

#[test]
fn classes_of_cached_parts_can_be_chosen_where_they_hold() {
    let folder = folder();
    flag(folder.path());
    for class in ["static", "free", "keyframed"] {
        let forced = format!("cloth={class}");
        let json = bake(folder.path(), &["flag.obj", "flag.pc2"], &["--class", &forced]);
        assert_eq!(json["parts"][0]["class"], class);
    }
    let run = restpose(
        folder.path(),
        [
            "bake",
            "flag.obj",
            "flag.pc2",
            "-o",
            "x.rpose",
            "--class",
            "cloth=rigid",
        ],
    );
    assert_eq!(run.code, 5, "{run:?}");
    assert!(run.stderr.contains("part \"cloth\" cannot be rigid"), "{run:?}");
}

#[test]
fn the_report_says_how_each_cache_was_baked() {
    let folder = folder();
    flag(folder.path());
    let start = ["bake", "flag.obj", "flag.pc2", "-o", "flag.rpose"];
    let run = restpose(folder.path(), start.iter().chain(&SEGMENTED)).succeeded();
    let expected = [
        " ms a frame with fuzzy trees, ",
        " ms rebuilt, at 0 rays on one thread",
        "cloth: 6 keys, positions within ",
        "bytes per vertex and key against 12",
        "  keys 0 to ",
        "rest key ",
        "residual ",
        "  2 segments against one: expected steps per ray ",
        "stone: 6 keys, ",
        "rigid components 1",
    ];
    for words in expected {
        assert!(run.stdout.contains(words), "{words}: {run:?}");
    }
    let info = restpose(folder.path(), ["info", "flag.rpose"]).succeeded();
    for words in ["vertex cache of", "for vertex caches at any time", "keyframed", "rigid"] {
        assert!(info.stdout.contains(words), "{words}: {info:?}");
    }
    let json = restpose(folder.path(), ["info", "flag.rpose", "--json"])
        .succeeded()
        .json();
    let segments = json["caches"][0]["segments"].as_array().expect("a list");
    assert_eq!(segments.len(), 2, "{json}");
    assert_eq!(segments[0]["key_last"], segments[1]["key_first"]);
    assert_eq!(segments[1]["key_last"], FRAMES - 1);
    let clusters: u64 = segments.iter().filter_map(|segment| segment["clusters"].as_u64()).sum();
    assert_eq!(json["parts"][0]["clusters"], clusters, "those of both segments");
    let verified = restpose(
        folder.path(),
        ["verify", "flag.rpose", "flag.obj", "flag.pc2", "--rays", "500"],
    );
    assert!(
        verified
            .succeeded()
            .stdout
            .contains("vertex caches at keys and at random times between")
    );
}

#[test]
fn a_file_whose_positions_leave_their_boxes_fails_verification() {
    let folder = folder();
    outgrown_flag(folder.path());
    restpose(folder.path(), ["validate", "bad_flag.rpose"]).succeeded();
    let verify = [
        "verify",
        "bad_flag.rpose",
        "flag.obj",
        "flag.pc2",
        "--rays",
        "5000",
        "--json",
    ];
    let run = restpose(folder.path(), verify);
    assert_eq!(run.code, 7, "{run:?}");
    let json = run.json();
    assert!(json["missed"].as_u64().is_some_and(|missed| missed > 0), "{json}");
    let frames = json["failures"][0]["cache_frames"].as_array().expect("a list");
    assert_eq!(frames.len(), 2, "one per cache: {json}");
}

#[test]
fn the_same_source_in_another_order_is_another_one() {
    let folder = folder();
    sequence(folder.path());
    let bake = ["bake", "frames/f0.obj", "frames/f1.obj", "-o", "x.rpose"];
    restpose(folder.path(), bake).succeeded();
    let run = restpose(folder.path(), ["verify", "x.rpose", "frames/f1.obj", "frames/f0.obj"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(run.stderr.contains("was not baked from this source"), "{run:?}");
}

#[test]
fn no_input_is_overwritten() {
    let folder = folder();
    flag(folder.path());
    fs::rename(folder.path().join("flag.pc2"), folder.path().join("cache.rpose")).expect("room");
    let before = fs::read(folder.path().join("cache.rpose")).expect("bytes");
    let run = restpose(
        folder.path(),
        ["bake", "flag.obj", "cache.rpose", "-o", "./cache.rpose"],
    );
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("input and output are the same file"), "{run:?}");
    assert_eq!(fs::read(folder.path().join("cache.rpose")).expect("bytes"), before);
}

#[test]
fn a_single_frame_is_static_with_a_warning() {
    let folder = folder();
    flag(folder.path());
    let run = restpose(
        folder.path(),
        ["bake", "flag.obj", "flag.pc2", "-o", "x.rpose", "--frames", "3-3"],
    )
    .succeeded();
    assert!(
        run.stderr
            .contains("warning: flag.obj with flag.pc2: only one frame is there or kept"),
        "{run:?}"
    );
    restpose(
        folder.path(),
        ["verify", "x.rpose", "flag.obj", "flag.pc2", "--rays", "500"],
    )
    .succeeded();
}

#[test]
fn the_bundled_goose_is_baked_and_verified() {
    let folder = folder();
    let (mesh, cache) = (sample("goose.obj"), sample("goose.pc2"));
    let inputs = [mesh.to_str().expect("text"), cache.to_str().expect("text")];
    let json = bake(folder.path(), &inputs, &["--rays-per-frame", "0", "--frames", "0-40/2"]);
    let classes: Vec<&str> = json["parts"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|part| part["class"].as_str())
        .collect();
    assert_eq!(classes, ["keyframed", "rigid", "static"]);
}
