use crate::{
    fixture::{door, folder},
    flag::{flag, mdd, pc2, sequence},
    run::{files, restpose},
};
use std::fs;

/// Inputs and options, the exit code, the file at fault, and words of the message.
type Case<'a> = (&'a [&'a str], i32, &'a str, &'a str);

const BAD: [Case; 16] = [
    (&["flag.pc2"], 1, "flag.pc2", "name the .obj file that it moves"),
    (
        &["flag.obj", "flag.pc2", "flag.mdd"],
        1,
        "flag.mdd",
        "is a second vertex cache",
    ),
    (
        &["flag.obj", "flag.pc2", "frames/f1.obj"],
        1,
        "frames/f1.obj",
        "is a second .obj file",
    ),
    (&["door.gltf", "flag.obj"], 1, "door.gltf", "goes with no other input"),
    (&["frames", "flag.obj"], 1, "frames", "goes with no other input"),
    (&["empty"], 1, "empty", "holds no .obj files"),
    (&["flag.obj", "none.pc2"], 2, "none.pc2", "cannot read"),
    (&["none.obj", "flag.pc2"], 2, "none.obj", "cannot read"),
    (
        &["flag.obj", "door.bin"],
        3,
        "door.bin",
        "neither content nor extension",
    ),
    (
        &["flag.obj", "other.obj"],
        3,
        "other.obj",
        "expected the faces of flag.obj",
    ),
    (
        &["flag.obj", "fewer.pc2"],
        3,
        "fewer.pc2",
        "has 9 points, but flag.obj has 38",
    ),
    (&["flag.obj", "cut.pc2"], 3, "cut.pc2", "truncated"),
    (&["flag.obj", "nan.pc2"], 3, "nan.pc2", "frame 5 point 37"),
    (&["broken.obj", "flag.pc2"], 3, "broken.obj", "line 1"),
    (
        &["flag.obj", "flag.pc2", "--frames", "2-6"],
        1,
        "flag.pc2",
        "asked for frames 2 to 6",
    ),
    (&["frames", "--frames", "9-"], 1, "frames", "asked for frames from 9"),
];

#[test]
fn bad_inputs_are_told_with_the_file_at_fault() {
    let folder = folder();
    let folder = folder.path();
    flag(folder);
    mdd(folder);
    sequence(folder);
    door(folder);
    fs::create_dir(folder.join("empty")).expect("room");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).expect("room");
    let whole = pc2(38);
    write("fewer.pc2", &pc2(9));
    write("cut.pc2", &whole[..whole.len() - 1]);
    write(
        "nan.pc2",
        &[&whole[..whole.len() - 4], &f32::NAN.to_le_bytes()].concat(),
    );
    write("other.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("broken.obj", b"v 0 zero 0\nf 1 1 1\n");
    let before = files(folder);
    for (inputs, code, path, words) in &BAD {
        let run = restpose(folder, [&["bake", "-o", "new.rpose", "--json"], *inputs].concat());
        assert_eq!(run.code, *code, "{inputs:?}: {run:?}");
        let error = &run.json()["error"];
        assert_eq!(
            (&error["code"], &error["path"]),
            (&(*code).into(), &(*path).into()),
            "{inputs:?}"
        );
        assert!(
            error["message"].as_str().is_some_and(|message| message.contains(words)),
            "{inputs:?}: {error}"
        );
        assert!(run.stderr.contains(path), "{inputs:?}: {run:?}");
        assert_eq!(files(folder), before, "{inputs:?}");
    }
}
