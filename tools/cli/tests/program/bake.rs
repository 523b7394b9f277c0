use crate::{
    fixture::{baked_door, door, folder, sample},
    run::{files, restpose},
};
use std::fs;

#[test]
fn parts_are_printed_with_class_and_reason() {
    let folder = folder();
    door(folder.path());
    let run = restpose(folder.path(), ["bake", "door.gltf", "-o", "door.rpose"]).succeeded();
    assert!(run.stdout.contains("part") && run.stdout.contains("because"), "{run:?}");
    for (part, class) in [("floor", "static"), ("door", "rigid")] {
        let line = run.stdout.lines().find(|line| line.starts_with(part));
        assert!(line.is_some_and(|line| line.contains(class)), "{run:?}");
    }
    assert!(
        run.stderr
            .contains("warning: door.gltf: /animations/0/samplers/0/output"),
        "{run:?}"
    );
    let names = files(folder.path());
    assert_eq!(names.len(), 3, "{names:?}");
}

#[test]
fn quiet_hides_all_but_errors() {
    let folder = folder();
    door(folder.path());
    let run = restpose(folder.path(), ["-q", "bake", "door.gltf", "-o", "door.rpose"]).succeeded();
    assert_eq!(run.stderr, "");
    let run = restpose(folder.path(), ["-q", "info", "none.rpose"]);
    assert!(run.stderr.starts_with("error: "), "{run:?}");
}

#[test]
fn the_file_does_not_depend_on_threads() {
    let folder = folder();
    let source = sample("walker.glb");
    let bake = |threads: &str, name: &str| {
        let source = source.to_str().expect("text");
        restpose(folder.path(), ["bake", source, "-o", name, "-j", threads]).succeeded();
        fs::read(folder.path().join(name)).expect("just baked")
    };
    assert_eq!(bake("1", "one.rpose"), bake("2", "two.rpose"));
}

#[test]
fn if_changed_bakes_only_when_something_changed() {
    let folder = folder();
    let file = baked_door(folder.path());
    let bake = |options: &[&str]| {
        let start = ["bake", "door.gltf", "-o", "door.rpose", "--if-changed", "--json"];
        restpose(folder.path(), start.iter().chain(options)).succeeded().json()["skipped"] == true
    };
    let written = || {
        fs::metadata(&file)
            .and_then(|metadata| metadata.modified())
            .expect("a time")
    };
    let first = written();
    assert!(bake(&[]));
    assert_eq!(written(), first, "a skipped bake leaves the file alone");

    assert!(!bake(&["--sample-step", "0.25"]), "other options");
    assert!(bake(&["--sample-step", "0.25"]));
    assert!(!bake(&[]));
    assert!(bake(&[]));

    let source = folder.path().join("door.gltf");
    let json = fs::read_to_string(&source).expect("text");
    fs::write(&source, json + "\n").expect("room");
    assert!(!bake(&[]), "another source");
    assert!(bake(&[]));

    let buffer = folder.path().join("door.bin");
    let mut bytes = fs::read(&buffer).expect("bytes");
    bytes[100] ^= 1;
    fs::write(&buffer, bytes).expect("room");
    assert!(!bake(&[]), "another buffer");

    let whole = fs::read(&file).expect("bytes");
    fs::write(&file, &whole[..whole.len() / 2]).expect("room");
    assert!(!bake(&[]), "a damaged file");
    assert_eq!(fs::read(&file).expect("bytes"), whole);
}

#[test]
fn clips_and_classes_can_be_chosen() {
    let folder = folder();
    door(folder.path());
    let bake = |options: &[&str]| {
        let start = ["bake", "door.gltf", "-o", "door.rpose", "--json"];
        restpose(folder.path(), start.iter().chain(options)).succeeded().json()
    };
    let json = bake(&["--clip", "swing", "--class", "floor=rigid", "--sample-step", "0.5"]);
    assert_eq!(json["parts"][0]["class"], "rigid");
    // The pose of the file, then 0, 0.5 and 1 s.
    assert_eq!(json["samples"], 4);
    assert_eq!(bake(&["--class", "door=static"])["parts"][1]["class"], "static");
}

#[test]
fn a_failed_bake_leaves_the_older_file() {
    let folder = folder();
    let file = baked_door(folder.path());
    let whole = fs::read(&file).expect("just baked");
    fs::write(folder.path().join("door.gltf"), "{}").expect("room");
    assert_eq!(
        restpose(folder.path(), ["bake", "door.gltf", "-o", "door.rpose"]).code,
        3
    );
    assert_eq!(fs::read(&file).expect("bytes"), whole);
}
