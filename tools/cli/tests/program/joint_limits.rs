use crate::{
    fixture::{changed_door, door, folder, sample},
    run::{files, restpose},
};
use std::fs;

/// The contents of a joint-limit file for the walker, the exit code, and words of the message.
const BAD: [(&[u8], i32, &str); 13] = [
    (b"", 3, "line 1: missing field `joints`"),
    (b"joints = [", 3, "line 1: "),
    (b"[joints.hip]\n\n# \xff", 3, "line 3: not UTF-8"),
    (
        b"[joints.hip]\nw = [0, 1]\n",
        3,
        "line 2, joints.hip.w: unknown field `w`, expected one of `x`, `y`, `z`",
    ),
    (
        b"[joints.hip]\nx = [0, 1, 2]\n",
        3,
        "line 2, joints.hip.x: invalid length 3, expected two angles",
    ),
    (
        b"[joints.hip]\nx = [0, \"1\"]\n",
        3,
        "line 2, joints.hip.x[1]: invalid type",
    ),
    (
        b"[joints.hip]\n[bones]\n",
        3,
        "unknown field `bones`, expected `joints`",
    ),
    (
        b"[joints.hip]\ny = [0, nan]\n",
        3,
        "joint \"hip\": y = NaN; expected degrees from -180 to 180",
    ),
    (b"[joints.hip]\ny = [-inf, 0]\n", 3, "joint \"hip\": y = -inf; expected"),
    (
        b"[joints.hip]\nz = [-5, 180.5]\n",
        3,
        "joint \"hip\": z = 180.5; expected",
    ),
    (
        b"[joints.hip]\nz = [5, -5]\n",
        3,
        "joint \"hip\": z = [5, -5] is reversed; expected the least angle first",
    ),
    (
        b"[joints.tail]\nx = [0, 1]\n[joints.\"third eye\"]\n",
        3,
        "no joint is called \"tail\", \"third eye\"; the skins have: ",
    ),
    (&[b' '; (1 << 20) + 1], 3, "is longer than 1048576 bytes"),
];

#[test]
fn bad_files_are_told_and_leave_nothing_behind() {
    let folder = folder();
    let folder = folder.path();
    let walker = sample("walker.glb").display().to_string();
    let limits = folder.join("limits.toml");
    let bake = |file: &str| {
        let options = ["--pose-space", "limits", "--joint-limits", file, "--json"];
        restpose(folder, ["bake", &walker, "-o", "new.rpose"].iter().chain(&options))
    };
    for (contents, code, words) in BAD {
        fs::write(&limits, contents).expect("room");
        let before = files(folder);
        let run = bake("limits.toml");
        assert_eq!(run.code, code, "{words}: {run:?}");
        let error = &run.json()["error"];
        assert_eq!(error["path"], "limits.toml", "{words}");
        let message = error["message"].as_str().expect("text");
        assert!(
            message.starts_with("limits.toml: ") && message.contains(words),
            "{words}: {message}"
        );
        assert_eq!(files(folder), before, "{words}");
    }
    for (file, words) in [("none.toml", "none.toml: cannot read"), (".", "not an ordinary file")] {
        let run = bake(file);
        assert_eq!((run.code, &run.json()["error"]["path"]), (2, &file.into()), "{run:?}");
        assert!(run.stderr.contains(words), "{run:?}");
    }
}

#[test]
fn a_scene_without_joints_has_none_to_limit() {
    let folder = folder();
    door(folder.path());
    fs::write(folder.path().join("limits.toml"), "[joints.door]\n").expect("room");
    let options = ["--pose-space", "limits", "--joint-limits", "limits.toml"];
    let bake = ["bake", "door.gltf", "-o", "new.rpose"];
    let run = restpose(folder.path(), bake.iter().chain(&options));
    assert_eq!(run.code, 3, "{run:?}");
    assert!(
        run.stderr.contains("no joint is called \"door\"; the skins have: none"),
        "{run:?}"
    );
    let run = restpose(folder.path(), bake.iter().chain(&["--pose-space", "arbitrary"])).succeeded();
    assert!(run.stdout.contains("(0 random)"), "{run:?}");
}

/// Options of `bake`, and words of the message.
const ALONE: [(&[&str], &str); 14] = [
    (
        &["--joint-limits", "a.toml"],
        "--joint-limits does nothing without --pose-space limits",
    ),
    (
        &["--pose-space", "arbitrary", "--joint-limits", "a.toml"],
        "--joint-limits does nothing without --pose-space limits",
    ),
    (
        &["--limit-slack", "5"],
        "--limit-slack does nothing without --pose-space limits",
    ),
    (
        &["--pose-space", "clip=swing", "--pose-samples", "5"],
        "--pose-samples does nothing without --pose-space limits or --pose-space arbitrary",
    ),
    (
        &["--seed", "5"],
        "--seed does nothing without --pose-space limits or --pose-space arbitrary",
    ),
    (
        &["--bounds", "sampled", "--envelopes", "5"],
        "--envelopes does nothing without --bounds envelope",
    ),
    (
        &["--pose-space", "random"],
        "expected arbitrary, limits, clips or clip=NAME",
    ),
    (&["--pose-space", "clip="], "the clip's name is empty"),
    (
        &["--pose-space", "clip=jump"],
        "the pose space has no clip \"jump\"; the file has: swing",
    ),
    (
        &["--pose-space", "clip=1"],
        "the pose space has no clip \"1\"; the file has: swing",
    ),
    (&["--pose-samples", "0"], "expected a whole number from 1 to 100000"),
    (&["--limit-slack", "181"], "expected degrees, 0 to 180"),
    (&["--seed=-1"], "invalid digit found in string"),
    (&["--envelopes", "1025"], "expected a whole number from 1 to 1024"),
];

#[test]
fn options_that_do_not_go_together_are_told() {
    let folder = folder();
    door(folder.path());
    let before = files(folder.path());
    for (options, words) in ALONE {
        let run = restpose(
            folder.path(),
            ["bake", "door.gltf", "-o", "new.rpose"].iter().chain(options),
        );
        assert_eq!(run.code, 1, "{options:?}: {run:?}");
        assert!(run.stderr.contains(words), "{options:?}: {run:?}");
        assert_eq!(files(folder.path()), before, "{options:?}");
    }
}

#[test]
fn a_clip_that_is_left_out_cannot_be_the_pose_space() {
    let folder = folder();
    changed_door(folder.path(), |json| {
        let mut second = json["animations"][0].clone();
        second["name"] = "slam".into();
        json["animations"].as_array_mut().expect("clips").push(second);
    });
    let bake = |options: &[&str]| {
        let start = ["bake", "door.gltf", "-o", "door.rpose", "--clip", "slam"];
        restpose(folder.path(), start.iter().chain(options))
    };
    for name in ["clip=swing", "clip=0"] {
        let run = bake(&["--pose-space", name]);
        assert_eq!(run.code, 1, "{run:?}");
        assert!(run.stderr.contains("; the file has: slam"), "{run:?}");
    }
    for name in ["clip=slam", "clip=1"] {
        bake(&["--pose-space", name]).succeeded();
    }
}
