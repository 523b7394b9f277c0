use crate::{
    fixture::{baked_door, door, folder},
    run::{command, restpose},
};
use std::process::Stdio;

#[test]
fn piped_output_is_plain() {
    let folder = folder();
    door(folder.path());
    let bake = restpose(folder.path(), ["bake", "door.gltf", "-o", "door.rpose"]).succeeded();
    let info = restpose(folder.path(), ["info", "door.rpose"]).succeeded();
    let wrong = restpose(folder.path(), ["info", "door.rpose", "--colour"]);
    for run in [&bake, &info, &wrong] {
        assert!(
            !run.stdout.contains(['\x1b', '\r']) && !run.stderr.contains(['\x1b', '\r']),
            "{run:?}"
        );
    }
    assert!(bake.stderr.lines().any(|line| line == "bake: import"), "{bake:?}");
    assert_eq!(info.stderr, "");
}

#[test]
fn progress_can_be_forced_and_switched_off() {
    let folder = folder();
    door(folder.path());
    let bake = |when: &str| {
        restpose(
            folder.path(),
            ["bake", "door.gltf", "-o", "door.rpose", "--progress", when],
        )
        .succeeded()
    };
    assert!(bake("always").stderr.contains('\x1b'));
    let never = bake("never");
    assert!(
        never.stderr.lines().all(|line| line.starts_with("warning: ")),
        "{never:?}"
    );
}

#[test]
fn nothing_but_the_result_is_on_stdout() {
    let folder = folder();
    baked_door(folder.path());
    let run = restpose(folder.path(), ["validate", "door.rpose"]).succeeded();
    assert_eq!(run.stdout.lines().count(), 1, "{run:?}");
    assert!(run.stdout.starts_with("door.rpose: valid ("), "{run:?}");
}

#[test]
fn a_reader_that_closes_the_pipe_is_no_error() {
    let folder = folder();
    baked_door(folder.path());
    let mut child = command(folder.path(), ["info", "door.rpose"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_on_stdout_is_an_error_of_input_and_output() {
    let folder = folder();
    baked_door(folder.path());
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .expect("Linux has it");
    let output = command(folder.path(), ["info", "door.rpose"])
        .stdout(full)
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot write to stdout"));
}
