use crate::{
    fixture::{door, folder},
    flag::flag,
    run::{files, restpose},
};

#[test]
fn the_demo_shows_and_verifies_every_scene_in_the_folder() {
    let folder = folder();
    let scenes = folder.path().join("samples/scenes");
    std::fs::create_dir_all(&scenes).expect("room");
    door(&scenes);
    let run = restpose(folder.path(), ["demo"]).succeeded();
    let names = ["animation.gif", "shaded.png", "clusters.png", "boxes.png", "steps.png"];
    for name in names {
        let path = format!("out/demo/door/{name}");
        assert!(
            run.stdout.contains(&path) && folder.path().join(&path).is_file(),
            "{path}: {run:?}"
        );
    }
    let made = files(&folder.path().join("out"));
    // out/demo, out/demo/door, the five, the baked file, 24 frames.
    assert_eq!(made.len(), 2 + 5 + 1 + 24, "{made:?}");
    assert!(folder.path().join("out/demo/door/door.rpose").is_file());
}

#[test]
fn a_mesh_and_its_vertex_cache_are_one_scene() {
    let folder = folder();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir_all(&scenes).expect("room");
    flag(&scenes);
    let run = restpose(folder.path(), ["demo", "--scenes", "scenes", "-o", "new", "--json"]).succeeded();
    let shown = &run.json()["scenes"];
    assert_eq!(shown.as_array().map(Vec::len), Some(1), "{shown}");
    assert_eq!(shown[0]["sources"].as_array().map(Vec::len), Some(2), "{shown}");
    // The stone, and the cloth: so few triangles that a hierarchy in every frame costs less than clusters.
    assert_eq!(shown[0]["clusters"].as_u64(), Some(2), "{shown}");
    assert!(
        shown[0]["verify"]["hits"].as_u64().is_some_and(|hits| hits > 1000),
        "{shown}"
    );
    assert!(folder.path().join("new/flag/clusters.png").is_file());
}

#[test]
fn a_scene_that_cannot_be_baked_leaves_nothing_of_itself() {
    let folder = folder();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir_all(&scenes).expect("room");
    std::fs::write(scenes.join("bad.gltf"), "{}").expect("room");
    let run = restpose(folder.path(), ["demo", "--scenes", "scenes", "-o", "new"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(!folder.path().join("new").exists());
}
