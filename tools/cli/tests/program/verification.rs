use crate::{
    fixture::{baked_door, door, folder, outgrown_door, sample},
    run::restpose,
};
use serde_json::Value;
use std::fs;

#[test]
fn a_fresh_file_passes() {
    let folder = folder();
    let source = sample("walker.glb");
    let source = source.to_str().expect("text");
    restpose(folder.path(), ["bake", source, "-o", "walker.rpose"]).succeeded();
    let run = restpose(
        folder.path(),
        ["verify", "walker.rpose", source, "--rays", "2000", "--json"],
    )
    .succeeded();
    let json = run.json();
    assert_eq!(
        (&json["passed"], &json["rays"], &json["missed"], &json["wrong"]),
        (&true.into(), &2000.into(), &0.into(), &0.into())
    );
    assert!(json["hits"].as_u64().is_some_and(|hits| hits > 200), "{json}");
    assert!(
        json["max_vertex_error"].as_f64().is_some_and(|error| error < 1e-5),
        "{json}"
    );
    let run = restpose(folder.path(), ["verify", "walker.rpose", source, "--rays", "2000"]).succeeded();
    for line in ["rays ", "poses ", "hits ", "missed ", "wrong ", "max vertex error "] {
        assert!(
            run.stdout.lines().any(|found| found.starts_with(line)),
            "{line}: {run:?}"
        );
    }
}

#[test]
fn the_seed_chooses_the_rays() {
    let folder = folder();
    baked_door(folder.path());
    let hits = |seed: &str| {
        let arguments = [
            "verify",
            "door.rpose",
            "door.gltf",
            "--rays",
            "3000",
            "--json",
            "--seed",
            seed,
        ];
        restpose(folder.path(), arguments).succeeded().json()["hits"].clone()
    };
    assert_eq!(hits("5"), hits("5"));
    assert_ne!(hits("5"), hits("6"));
}

#[test]
fn a_file_with_boxes_too_small_fails_with_its_own_code() {
    let folder = folder();
    outgrown_door(folder.path());
    restpose(folder.path(), ["validate", "bad.rpose"]).succeeded();

    let run = restpose(
        folder.path(),
        ["verify", "bad.rpose", "door.gltf", "--rays", "5000", "--json"],
    );
    assert_eq!(run.code, 7, "{run:?}");
    let json = run.json();
    assert_eq!(json["passed"], false);
    assert_eq!(json["error"]["code"], 7);
    assert!(json["missed"].as_u64().is_some_and(|missed| missed > 0), "{json}");
    assert!(!json["failures"].as_array().expect("a list").is_empty());
    assert!(run.stderr.contains("verification failed"), "{run:?}");
    let run = restpose(folder.path(), ["verify", "bad.rpose", "door.gltf", "--rays", "5000"]);
    assert_eq!(run.code, 7);
    assert!(
        run.stdout.contains("missed "),
        "the result is printed all the same: {run:?}"
    );
}

#[test]
fn another_source_is_refused() {
    let folder = folder();
    baked_door(folder.path());
    let source = door(folder.path());
    let json = fs::read_to_string(&source).expect("text");
    fs::write(&source, json + " ").expect("room");
    let run = restpose(folder.path(), ["verify", "door.rpose", "door.gltf"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(run.stderr.contains("was not baked from this source"), "{run:?}");
}

/// The names and counts of the families, as JSON lists them.
fn families(json: &Value) -> Vec<(&str, u64)> {
    let families = json["families"].as_array().expect("a list");
    families
        .iter()
        .map(|family| {
            (
                family["family"].as_str().expect("text"),
                family["poses"].as_u64().expect("a count"),
            )
        })
        .collect()
}

#[test]
fn poses_come_from_samples_clips_or_nowhere() {
    let folder = folder();
    baked_door(folder.path());
    let verify = |source: &[&str]| {
        let arguments = [
            "verify",
            "door.rpose",
            "door.gltf",
            "--rays",
            "2000",
            "--poses",
            "20",
            "--json",
        ];
        restpose(folder.path(), arguments.iter().chain(source))
            .succeeded()
            .json()
    };
    for (arguments, source) in [
        (&[][..], "clips"),
        (&["--pose-source", "samples"], "samples"),
        (&["--pose-source", "clips"], "clips"),
    ] {
        let json = verify(arguments);
        assert_eq!((&json["pose_source"], &json["poses"]), (&source.into(), &20.into()));
        assert_eq!(families(&json), []);
    }
    // The door is rigid: no pose is outside of what its boxes hold.
    let json = verify(&["--pose-source", "random"]);
    let found = families(&json);
    assert_eq!(found.len(), 10, "all but the morphs: {found:?}");
    assert!(
        found.iter().all(|(name, poses)| *name != "morphs" && *poses == 2),
        "{found:?}"
    );
    assert!(
        json["max_vertex_error"].as_f64().is_some_and(|error| error < 1e-5),
        "{json}"
    );
    assert_eq!(verify(&["--pose-source", "random"])["hits"], json["hits"]);
    assert_ne!(
        verify(&["--pose-source", "random", "--seed", "2"])["hits"],
        json["hits"]
    );

    let run = restpose(
        folder.path(),
        [
            "verify",
            "door.rpose",
            "door.gltf",
            "--rays",
            "500",
            "--pose-source",
            "random",
        ],
    );
    let text = run.succeeded().stdout;
    for words in ["(random, of 10 families)", "\nfamily ", "\nnear_singular "] {
        assert!(text.contains(words), "{words:?}: {text}");
    }
}

#[test]
fn sampled_boxes_fail_in_other_poses_and_the_message_says_why() {
    let folder = folder();
    let source = sample("walker.glb");
    let source = source.to_str().expect("text");
    restpose(
        folder.path(),
        ["bake", source, "-o", "walker.rpose", "--bounds", "sampled"],
    )
    .succeeded();
    let arguments = ["verify", "walker.rpose", source, "--rays", "6000", "--poses", "50"];
    let run = restpose(
        folder.path(),
        arguments.iter().chain(&["--pose-source", "random", "--json"]),
    );
    assert_eq!(run.code, 7, "{run:?}");
    let json = run.json();
    assert_eq!((&json["passed"], &json["bounds"]), (&false.into(), &"sampled".into()));
    let failure = &json["failures"][0];
    assert!(failure["family"].is_string() && failure["pose"].is_u64(), "{failure}");
    for key in ["sample", "clip", "seconds"] {
        assert!(failure[key].is_null(), "{key}: {failure}");
    }
    assert!(run.stderr.contains("bounded around samples"), "{}", run.stderr);
}

#[test]
fn envelopes_hold_in_other_poses_and_families_say_how_far_these_are() {
    let folder = folder();
    let source = sample("walker.glb");
    let source = source.to_str().expect("text");
    restpose(
        folder.path(),
        ["bake", source, "-o", "walker.rpose", "--bounds", "envelope"],
    )
    .succeeded();
    let arguments = ["verify", "walker.rpose", source, "--rays", "2000", "--poses", "20"];
    let arguments = arguments.iter().chain(&["--pose-source", "random"]);
    let json = restpose(folder.path(), arguments.clone().chain(&["--json"]))
        .succeeded()
        .json();
    assert_eq!((&json["passed"], &json["bounds"]), (&true.into(), &"envelope".into()));
    for family in json["families"].as_array().expect("a list") {
        let outside = family["clusters_outside"].as_u64().expect("a count");
        assert!(
            outside > 0 && outside <= family["clusters"].as_u64().expect("a count"),
            "{family}"
        );
        assert!(
            family["largest_excess"].as_f64().is_some_and(|excess| excess > 0.0),
            "{family}"
        );
    }
    let text = restpose(folder.path(), arguments).succeeded().stdout;
    for words in [" outside ", " largest excess"] {
        assert!(text.contains(words), "{words:?}: {text}");
    }
}

#[test]
fn unknown_pose_sources_are_refused() {
    let folder = folder();
    baked_door(folder.path());
    let run = restpose(
        folder.path(),
        ["verify", "door.rpose", "door.gltf", "--pose-source", "dance"],
    );
    assert_eq!(run.code, 1, "{run:?}");
    for word in ["samples", "clips", "random"] {
        assert!(run.stderr.contains(word), "{word}: {run:?}");
    }
}
