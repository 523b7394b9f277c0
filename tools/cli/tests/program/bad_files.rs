use crate::{
    fixture::{baked_door, changed_door, door, flat_door, folder, sample},
    run::{files, restpose},
};
use serde_json::json;
use std::path::Path;

#[track_caller]
fn refused(folder: &Path, source: &str, code: i32, words: &str) {
    let before = files(folder);
    let run = restpose(folder, ["bake", source, "-o", "new.rpose", "--json"]);
    assert_eq!(run.code, code, "{run:?}");
    assert!(run.stderr.contains(words) && run.stderr.contains(source), "{run:?}");
    assert_eq!(run.json()["error"]["code"], code);
    assert_eq!(files(folder), before);
}

#[test]
fn sources_that_are_not_gltf_are_refused() {
    let folder = folder();
    let contents: [(&str, &[u8]); 4] = [
        ("empty.glb", b""),
        ("text.glb", b"Dear reader,\n"),
        ("half.gltf", b"{\"asset\":"),
        ("zeros.glb", &[0; 64]),
    ];
    for (name, bytes) in contents {
        std::fs::write(folder.path().join(name), bytes).expect("room");
        refused(folder.path(), name, 3, "error: ");
    }
    let whole = std::fs::read(sample("walker.glb")).expect("the sample");
    std::fs::write(folder.path().join("cut.glb"), &whole[..whole.len() / 2]).expect("room");
    refused(folder.path(), "cut.glb", 3, "cut.glb");
}

#[test]
fn every_fault_of_a_source_is_listed_with_its_pointer() {
    let folder = folder();
    changed_door(folder.path(), |json| {
        json["accessors"][0]["count"] = json!(7);
        json["animations"][0]["channels"][0]["target"]["node"] = json!(9);
    });
    let run = restpose(folder.path(), ["bake", "door.gltf", "-o", "new.rpose", "--json"]);
    assert_eq!(run.code, 3, "{run:?}");
    let json = run.json();
    let faults = json["error"]["faults"].as_array().expect("a list");
    for pointer in ["/accessors/0", "/animations/0/channels/0/target/node"] {
        let listed = faults
            .iter()
            .any(|fault| fault["path"].as_str().is_some_and(|path| path.starts_with(pointer)));
        assert!(listed, "{pointer}: {faults:?}");
        assert!(run.stderr.contains(pointer), "{run:?}");
    }
    assert!(
        faults
            .iter()
            .all(|fault| fault["severity"] == "error" && fault["message"].is_string()),
        "{faults:?}"
    );
}

#[test]
fn a_missing_buffer_is_named_with_its_pointer() {
    let folder = folder();
    door(folder.path());
    std::fs::remove_file(folder.path().join("door.bin")).expect("just written");
    refused(
        folder.path(),
        "door.gltf",
        3,
        "/buffers/0/uri: cannot read \"door.bin\"",
    );
}

#[test]
fn an_unknown_required_extension_is_named() {
    let folder = folder();
    changed_door(folder.path(), |json| {
        json["extensionsUsed"] = json!(["ACME_folding"]);
        json["extensionsRequired"] = json!(["ACME_folding"]);
    });
    refused(folder.path(), "door.gltf", 5, "ACME_folding");
}

#[test]
fn a_source_without_any_area_is_refused() {
    let folder = folder();
    flat_door(folder.path());
    refused(folder.path(), "door.gltf", 3, "no triangle has an area");
}

#[test]
fn damaged_baked_files_are_refused_by_every_command() {
    let folder = folder();
    let whole = std::fs::read(baked_door(folder.path())).expect("just baked");
    let mut flipped = whole.clone();
    *flipped.last_mut().expect("bytes") ^= 1;
    let damaged = [
        whole[..whole.len() - 1].to_vec(),
        [&whole[..], &[0]].concat(),
        flipped,
        b"text".to_vec(),
        Vec::new(),
    ];
    for bytes in damaged {
        std::fs::write(folder.path().join("bad.rpose"), bytes).expect("room");
        let before = files(folder.path());
        let commands: [&[&str]; 4] = [
            &["info", "bad.rpose"],
            &["validate", "bad.rpose"],
            &["verify", "bad.rpose", "door.gltf"],
            &["render", "bad.rpose", "-o", "a/b"],
        ];
        for arguments in commands {
            let run = restpose(folder.path(), arguments);
            assert_eq!(run.code, 3, "{arguments:?}: {run:?}");
            assert!(run.stderr.contains("error: bad.rpose: "), "{arguments:?}: {run:?}");
            assert_eq!(run.stdout, "");
            assert_eq!(files(folder.path()), before);
        }
    }
}
