use crate::{
    fixture::{baked_door, changed_door, door, folder},
    run::{files, restpose},
};

/// A command line, the exit code, and words of the message.
type Case<'a> = (&'a [&'a str], i32, &'a str);

/// What clap refuses before anything else happens.
const USAGE: [Case; 33] = [
    (&[], 1, "Usage"),
    (&["bend"], 1, "unrecognized subcommand"),
    (&["bake"], 1, "required arguments"),
    (&["bake", "door.gltf"], 1, "--output"),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--colour"],
        1,
        "unexpected argument",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--sample-step", "0"],
        1,
        "expected a number above 0, at most 10",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--sample-step", "nan"],
        1,
        "expected a number above 0",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--class", "door"],
        1,
        "expected PART=CLASS",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--class", "door=liquid"],
        1,
        "no motion class \"liquid\"",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--bounds", "none"],
        1,
        "possible values: sampled, envelope",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--frames=5"],
        1,
        "expected FIRST-[LAST][/STEP]",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--frame-rate=0"],
        1,
        "expected a number above 0, at most 1000000",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--position-error=-1"],
        1,
        "expected a finite number, 0 or more",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--max-clusters=0"],
        1,
        "expected a whole number from 1 to 65536",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--cluster-threshold=2"],
        1,
        "expected a number from 0 to 1",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--iteration-threshold=nan"],
        1,
        "expected a number from 0 to 1",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--max-iterations=0"],
        1,
        "expected a whole number from 1 to 1000000",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--rest-step=1.5"],
        1,
        "expected a whole number from 1 to 1000000",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--principal-axes=yes"],
        1,
        "expected on or off",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--segments=0"],
        1,
        "expected a whole number from 1 to 65536",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--size-worth=inf"],
        1,
        "expected a finite number, 0 or more",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--rays-per-frame=few"],
        1,
        "expected a finite number, 0 or more",
    ),
    (
        &["info", "door.rpose", "-j", "0"],
        1,
        "expected a whole number from 1 to 1024",
    ),
    (
        &["info", "door.rpose", "--progress", "maybe"],
        1,
        "possible values: auto, always, never",
    ),
    (
        &["verify", "door.rpose", "door.gltf", "--rays", "0"],
        1,
        "0 is not in 1..=1000000000",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--frames", "0"],
        1,
        "0 is not in 1..=9999",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--size", "8x8"],
        1,
        "each side must be 16 to 8192 pixels",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--size", "big"],
        1,
        "expected WIDTHxHEIGHT",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--light", "0,0,0"],
        1,
        "a direction cannot be 0,0,0",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--light", "1,2"],
        1,
        "expected three numbers written x,y,z, found 2",
    ),
    (&["render", "door.rpose", "-o", "new", "--from", "-1"], 1, "expected"),
    (
        &["render", "door.rpose", "-o", "new", "--samples", "2"],
        1,
        "possible values: 1, 4, 16",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--camera", "1,1,1", "--yaw", "3"],
        1,
        "cannot be used with",
    ),
];

/// What does not fit the files.
const FILES: [Case; 23] = [
    (
        &["bake", "door.gltf", "-o", "new.bin"],
        1,
        "new.bin: the output's name must end in .rpose",
    ),
    (&["bake", "door.gltf", "-o", "new"], 1, "must end in .rpose"),
    (
        &["bake", "door.rpose", "-o", "door.rpose"],
        1,
        "input and output are the same file",
    ),
    (
        &["bake", "door.gltf", "-o", "folder.rpose"],
        1,
        "folder.rpose: is a folder",
    ),
    (
        &["bake", "folder.rpose", "-o", "new.rpose"],
        1,
        "folder.rpose: the folder holds no .obj files",
    ),
    (&["bake", "none.gltf", "-o", "new.rpose"], 2, "none.gltf: cannot read"),
    (
        &["bake", "door.gltf", "-o", "none/new.rpose"],
        2,
        "none: is not a folder",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--clip", "jump"],
        1,
        "no clip is called \"jump\"; the source has: swing",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--class", "roof=rigid"],
        1,
        "no part is called \"roof\"",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--class", "door=skinned"],
        5,
        "part \"door\" cannot be skinned",
    ),
    (
        &["bake", "door.gltf", "-o", "new.rpose", "--sample-step", "1e-9"],
        1,
        "take a longer sample step",
    ),
    (&["info", "none.rpose"], 2, "none.rpose: cannot read"),
    (&["info", "folder.rpose"], 1, "is a folder; name a file"),
    (&["validate", "none.rpose"], 2, "none.rpose: cannot read"),
    (&["verify", "none.rpose", "door.gltf"], 2, "none.rpose: cannot read"),
    (&["verify", "door.rpose", "none.gltf"], 2, "none.gltf: cannot read"),
    (&["render", "none.rpose", "-o", "new"], 2, "none.rpose: cannot read"),
    (
        &["render", "door.rpose", "-o", "door.gltf"],
        1,
        "door.gltf: is not a folder",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--clip", "jump"],
        1,
        "no clip \"jump\": the file has 0 \"swing\"",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--clip", "1"],
        1,
        "no clip \"1\"",
    ),
    (
        &["render", "door.rpose", "-o", "new", "--from", "0.9", "--to", "0.1"],
        1,
        "--from 0.9 lies after --to 0.1",
    ),
    (
        &["measure", "frame", "door.gltf", "door.gltf", "--keep", "new"],
        1,
        "--keep would write both to one file",
    ),
    (
        &["demo", "--scenes", "none", "-o", "new"],
        2,
        "none: cannot read the sample scenes",
    ),
];

#[test]
fn wrong_command_lines_are_told_and_leave_nothing_behind() {
    let folder = folder();
    baked_door(folder.path());
    std::fs::create_dir(folder.path().join("folder.rpose")).expect("room");
    let before = files(folder.path());
    for (arguments, code, words) in USAGE.iter().chain(&FILES) {
        let run = restpose(folder.path(), *arguments);
        assert_eq!(run.code, *code, "{arguments:?}: {run:?}");
        assert!(run.stderr.contains(words), "{arguments:?}: {run:?}");
        assert_eq!(run.stdout, "", "{arguments:?}");
        assert_eq!(files(folder.path()), before, "{arguments:?}");
    }
}

#[test]
fn with_json_a_failure_is_one_object_with_the_same_code_and_message() {
    let folder = folder();
    baked_door(folder.path());
    std::fs::create_dir(folder.path().join("folder.rpose")).expect("room");
    let names = [(1, "command_line"), (2, "io"), (5, "unsupported")];
    // Without any command clap prints help for people whatever follows.
    for (arguments, code, words) in USAGE.iter().skip(1).chain(&FILES) {
        let run = restpose(folder.path(), arguments.iter().chain(&["--json"]));
        assert_eq!(run.code, *code, "{arguments:?}: {run:?}");
        let error = &run.json()["error"];
        assert_eq!(error["code"], *code, "{arguments:?}");
        assert!(
            names
                .iter()
                .any(|(number, name)| number == code && error["name"] == *name),
            "{arguments:?}: {error}"
        );
        let message = error["message"].as_str().expect("text");
        let first_words = words.split(':').next().expect("a split has a first part");
        assert!(
            message.contains(first_words) || first_words.starts_with("possible"),
            "{arguments:?}: {message}"
        );
        assert!(error["faults"].is_array(), "{arguments:?}");
        assert!(run.stderr.contains("error: "), "{arguments:?}: {run:?}");
    }
}

#[test]
fn a_failure_about_a_file_names_its_path() {
    let folder = folder();
    let run = restpose(folder.path(), ["info", "none.rpose", "--json"]);
    assert_eq!(run.json()["error"]["path"], "none.rpose");
    let run = restpose(folder.path(), ["info", "--json"]);
    assert!(run.json()["error"]["path"].is_null());
}

#[test]
fn times_need_a_clip() {
    let folder = folder();
    changed_door(folder.path(), |json| {
        drop(json.as_object_mut().expect("an object").remove("animations"))
    });
    restpose(folder.path(), ["bake", "door.gltf", "-o", "still.rpose"]).succeeded();
    for option in [["--from", "0"], ["--clip", "0"]] {
        let run = restpose(
            folder.path(),
            ["render", "still.rpose", "-o", "new"].iter().chain(&option),
        );
        assert_eq!(run.code, 1, "{run:?}");
        assert!(run.stderr.contains("the file has no clips"), "{run:?}");
    }
    let size = ["--size", "32x32"];
    let run = restpose(
        folder.path(),
        ["render", "still.rpose", "-o", "new"].iter().chain(&size),
    )
    .succeeded();
    assert_eq!(run.stdout, "1 frame and animation.gif in new\n");
}

#[test]
fn an_empty_folder_of_samples_is_told() {
    let folder = folder();
    door(folder.path());
    std::fs::create_dir(folder.path().join("empty")).expect("room");
    let run = restpose(folder.path(), ["demo", "--scenes", "empty", "-o", "new"]);
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.stderr.contains("holds no sample scenes"), "{run:?}");
    assert!(!folder.path().join("new").exists());
}
