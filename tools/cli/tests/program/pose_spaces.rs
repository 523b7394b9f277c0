use crate::{
    fixture::{folder, sample},
    run::{Run, restpose},
};
use std::{fs, path::Path};

fn bake(folder: &Path, output: &str, options: &[&str]) -> Run {
    let walker = sample("walker.glb").display().to_string();
    let start = ["bake", walker.as_str(), "-o", output, "--json"];
    restpose(folder, start.iter().chain(options)).succeeded()
}

#[test]
fn more_poses_make_larger_boxes() {
    let folder = folder();
    let folder = folder.path();
    let listed = |file: &str| restpose(folder, ["info", file, "--json"]).succeeded().json();
    let clip = listed_first_clip(folder);
    let one = format!("clip={clip}");
    let spaces = [one.as_str(), "clips", "limits", "arbitrary"];
    let baked = spaces.map(|space| bake(folder, "walker.rpose", &["--pose-space", space]).json());
    // Every pose space contains those before it but for the limits, which are wide enough here.
    let areas = baked
        .each_ref()
        .map(|report| report["fuzzy_box_area"].as_f64().expect("a number"));
    assert!(areas.is_sorted() && areas[0] < areas[3], "{areas:?}");
    let random = baked
        .each_ref()
        .map(|report| report["random_poses"].as_u64().expect("a number"));
    assert_eq!(random, [0, 0, 245, 1000]);
    let samples = baked
        .each_ref()
        .map(|report| report["samples"].as_u64().expect("a number"));
    assert_eq!(samples[2..], [samples[1] + 245, samples[1] + 1000]);
    let file = listed("walker.rpose");
    assert_eq!(
        file["counts"]["samples"], samples[1],
        "random poses are not clips' samples"
    );
    for (name, value) in [("pose_space", "arbitrary"), ("pose_samples", "1000"), ("seed", "1")] {
        assert_eq!(file["options"][name], value);
    }
    assert!(file["options"]["joint_limits"].is_null());
    assert_eq!(file["options"]["envelopes"], "64");
}

fn listed_first_clip(folder: &Path) -> String {
    bake(folder, "all.rpose", &[]);
    let file = restpose(folder, ["info", "all.rpose", "--json"]).succeeded().json();
    assert_eq!(file["options"]["pose_space"], "clips");
    assert!(file["options"]["seed"].is_null());
    file["clips"][0]["name"].as_str().expect("text").to_owned()
}

#[test]
fn the_other_clips_stay_in_the_file() {
    let folder = folder();
    let clip = listed_first_clip(folder.path());
    bake(folder.path(), "one.rpose", &["--pose-space", &format!("clip={clip}")]);
    let [all, one] =
        ["all.rpose", "one.rpose"].map(|file| restpose(folder.path(), ["info", file, "--json"]).succeeded().json());
    assert_eq!(all["clips"], one["clips"]);
    assert_eq!(one["options"]["pose_space"], format!("clip {clip:?}"));
}

#[test]
fn random_poses_do_not_depend_on_threads_but_on_seed_and_limits() {
    let folder = folder();
    let folder = folder.path();
    let info = {
        bake(folder, "walker.rpose", &[]);
        restpose(folder, ["info", "walker.rpose", "--json"]).succeeded().json()
    };
    let joint = info["clusters"]
        .as_array()
        .and_then(|clusters| clusters.last())
        .expect("a cluster")["bone_name"]
        .clone();
    let write = |degrees: u32| {
        let text = format!("[joints.{joint}]\nx = [-10, {degrees}]\n");
        fs::write(folder.join("limits.toml"), text).expect("room");
    };
    write(30);
    let limits = [
        "--pose-space",
        "limits",
        "--joint-limits",
        "limits.toml",
        "--pose-samples",
        "40",
    ];
    let file = |options: &[&str]| {
        bake(folder, "walker.rpose", &[&limits[..], options].concat());
        fs::read(folder.join("walker.rpose")).expect("just baked")
    };
    let one = file(&["-j", "1"]);
    assert_eq!(one, file(&["-j", "2"]));
    assert_ne!(one, file(&["--seed", "2"]));
    assert_ne!(one, file(&["--limit-slack", "11"]));
    file(&[]);
    let unchanged = |options: &[&str]| {
        bake(
            folder,
            "walker.rpose",
            &[&limits[..], &["--if-changed"], options].concat(),
        )
        .json()["skipped"]
            == true
    };
    assert!(unchanged(&[]));
    fs::rename(folder.join("limits.toml"), folder.join("moved.toml")).expect("the same folder");
    let moved = [
        "--pose-space",
        "limits",
        "--joint-limits",
        "moved.toml",
        "--pose-samples",
        "40",
        "--if-changed",
    ];
    assert_eq!(bake(folder, "walker.rpose", &moved).json()["skipped"], true);
    write(31);
    assert!(!unchanged(&[]));
    let options = &restpose(folder, ["info", "walker.rpose", "--json"]).succeeded().json()["options"];
    assert_eq!(options["joint_limits"], format!("{joint} -10..31 0..0 0..0"));
    assert_eq!(options["limit_slack_deg"], "10");
}
