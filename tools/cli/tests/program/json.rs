use crate::{
    fixture::{baked_door, door, folder, outgrown_door, sample},
    flag::{SEGMENTED, baked_flag, flag, outgrown_flag},
    run::restpose,
};
use serde_json::Value;
use std::{collections::BTreeSet, fs, path::Path};

/// Keys whose contents are listed elsewhere or free.
const OPAQUE: [&str; 6] = [
    "options",
    "scenes[].verify",
    "seconds",
    "failures[].expected",
    "failures[].found",
    "clips[].bounds",
];

/// The keys in the tables of `JSON.md` under this heading.
fn documented(heading: &str) -> BTreeSet<String> {
    let text = include_str!("../../JSON.md");
    let section = text
        .split("\n## ")
        .find(|section| section.lines().next() == Some(heading))
        .expect("the heading");
    let keys = section
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    keys.map(str::to_owned).collect()
}

/// The keys of an object as `JSON.md` writes them.
fn keys(value: &Value, prefix: &str, known: &BTreeSet<String>, found: &mut BTreeSet<String>) {
    if known.contains(prefix) && OPAQUE.contains(&prefix) {
        found.insert(prefix.to_owned());
        return;
    }
    match value {
        Value::Object(fields) => {
            let dot = if prefix.is_empty() { "" } else { "." };
            fields
                .iter()
                .for_each(|(name, value)| keys(value, &format!("{prefix}{dot}{name}"), known, found));
        }
        Value::Array(entries) => entries
            .iter()
            .for_each(|entry| keys(entry, &format!("{prefix}[]"), known, found)),
        _ => drop(found.insert(prefix.to_owned())),
    }
}

/// Fails unless these runs print the documented keys, all of them and no others.
#[track_caller]
fn agree(heading: &str, folder: &Path, runs: &[&[&str]]) {
    let known = &documented(heading) | &documented("Failure");
    let mut found = BTreeSet::new();
    for arguments in runs {
        let run = restpose(folder, arguments.iter().chain(&["--json"]));
        assert_eq!(run.stdout.lines().count(), 1, "{run:?}");
        keys(&run.json(), "", &known, &mut found);
    }
    let own: Vec<_> = documented(heading).difference(&found).cloned().collect();
    let other: Vec<_> = found.difference(&known).cloned().collect();
    assert!(
        own.is_empty() && other.is_empty(),
        "{heading}: documented only {own:?}, printed only {other:?}"
    );
}

#[test]
fn bake_prints_its_keys() {
    let folder = folder();
    door(folder.path());
    let bake: &[&str] = &["bake", "door.gltf", "-o", "door.rpose"];
    flag(folder.path());
    let keyframed = [&["bake", "flag.obj", "flag.pc2", "-o", "flag.rpose"], &SEGMENTED[..]].concat();
    agree(
        "bake",
        folder.path(),
        &[bake, &[bake, &["--if-changed"]].concat(), &keyframed],
    );
}

#[test]
fn the_other_commands_print_their_keys() {
    let folder = folder();
    baked_door(folder.path());
    baked_flag(folder.path(), &[]);
    agree(
        "info",
        folder.path(),
        &[&["info", "door.rpose"], &["info", "flag.rpose"]],
    );
    agree("validate", folder.path(), &[&["validate", "door.rpose"]]);
    agree(
        "render",
        folder.path(),
        &[&["render", "door.rpose", "-o", "out", "--size", "32x32", "--frames", "2"]],
    );
    agree("demo", folder.path(), &[&["demo", "--scenes", ".", "-o", "demo"]]);
}

#[test]
fn verify_prints_its_keys_and_the_failures() {
    let folder = folder();
    outgrown_door(folder.path());
    outgrown_flag(folder.path());
    let sound: &[&str] = &["verify", "door.rpose", "door.gltf", "--rays", "1000"];
    agree(
        "verify",
        folder.path(),
        &[
            sound,
            &[sound, &["--pose-source", "random"]].concat(),
            &["verify", "bad.rpose", "door.gltf", "--rays", "5000"],
            &["verify", "bad_flag.rpose", "flag.obj", "flag.pc2", "--rays", "5000"],
        ],
    );
}

#[test]
fn measure_frame_prints_its_keys() {
    let folder = folder();
    let scene = sample("walker.glb").display().to_string();
    let least = [
        "--rays",
        "1,2000",
        "--ray-kinds",
        "random,close-up",
        "--poses",
        "1",
        "--seconds",
        "0",
        "--thread-counts",
        "1",
        "--instances",
        "2",
        "-o",
        "out",
    ];
    let measure = [&["measure", "frame", scene.as_str(), scene.as_str()], &least[..]].concat();
    // What is kept of one measurement is the scene of the next.
    let keep = [&["measure", "frame", scene.as_str(), "--keep", "kept"], &least[..]].concat();
    agree("measure frame", folder.path(), &[&measure, &keep]);
    let again = [&["measure", "frame", "kept/walker-1-wide.rpose"], &least[..]].concat();
    let run = restpose(folder.path(), &again);
    assert_eq!(run.code, 0, "{run:?}");
    for name in ["frame.html", "frame.json"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn measure_tessellations_prints_its_keys() {
    let folder = folder();
    door(folder.path());
    let least = ["--subdivide", "0", "--frames", "1", "--thread-counts", "1", "-o", "out"];
    let measure = [&["measure", "tessellations", "door.gltf"], &least[..]].concat();
    agree("measure tessellations", folder.path(), &[&measure]);
    for name in ["tessellations.html", "tessellations.json"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn measure_motion_prints_its_keys() {
    let folder = folder();
    let [mesh, cache] = ["goose.obj", "goose.pc2"].map(|name| sample(name).display().to_string());
    let least = [
        "--frames",
        "0-3",
        "--max-clusters",
        "3",
        "--poses",
        "2",
        "--picture-side",
        "16",
        "--random-rays",
        "50",
        "--repeats",
        "1",
        "--thread-counts",
        "1",
        "-o",
        "out",
    ];
    let measure = [&["measure", "motion", mesh.as_str(), cache.as_str()], &least[..]].concat();
    agree("measure motion", folder.path(), &[&measure]);
    for name in ["motion.html", "motion.json"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn measure_poses_prints_its_keys() {
    let folder = folder();
    let scene = sample("tentacle.gltf").display().to_string();
    let least = [
        "--levels",
        "0",
        "--poses",
        "1",
        "--rays",
        "50",
        "--repeats",
        "1",
        "-o",
        "out",
    ];
    let measure = [&["measure", "poses", scene.as_str(), scene.as_str()], &least[..]].concat();
    agree("measure poses", folder.path(), &[&measure]);
    for name in ["poses.html", "poses.json"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn measure_builders_prints_its_keys() {
    let folder = folder();
    let [mesh, cache] = ["goose.obj", "goose.pc2"].map(|name| sample(name).display().to_string());
    let scene = format!("{mesh}+{cache}");
    let least = [
        "--generated",
        "uneven=300",
        "--repeats",
        "1",
        "--thread-counts",
        "1,2",
        "--picture-side",
        "16",
        "--random-rays",
        "50",
        "--animation-frames",
        "3",
        "-o",
        "out",
    ];
    let measure = [&["measure", "builders", scene.as_str()], &least[..]].concat();
    agree("measure builders", folder.path(), &[&measure]);
    for name in ["builders.html", "builders.json"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn a_failure_prints_its_keys() {
    let folder = folder();
    door(folder.path());
    fs::write(
        folder.path().join("bad.gltf"),
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":3}]}",
    )
    .expect("room");
    agree(
        "Failure",
        folder.path(),
        &[
            &["info", "none.rpose"],
            &["bake", "bad.gltf", "-o", "bad.rpose"],
            &["bend"],
        ],
    );
}
