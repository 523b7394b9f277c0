//! Groups of OBJ files become parts.

use crate::cache_builder::{clean, clean_mesh, frames, pc2};
use restpose_bake::import::{Animation, ImportSettings, import_obj_bytes};

const POINTS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

fn names(animation: &Animation) -> Vec<&str> {
    for (number, part) in animation.parts.iter().enumerate() {
        assert_eq!((part.node, part.mesh, part.skin), (0, number, None));
        assert_eq!(animation.meshes[number].name, part.name);
        assert_eq!(animation.meshes[number].primitives.len(), 1);
    }
    animation.parts.iter().map(|part| part.name.as_str()).collect()
}

#[test]
fn faces_without_group_are_named_after_the_file() {
    assert_eq!(names(&clean_mesh(&format!("{POINTS}f 1 2 3\n"))), ["mesh"]);
    assert_eq!(
        names(&clean_mesh(&format!("{POINTS}f 1 2 3\ng a\nf 1 2 4\n"))),
        ["mesh", "a"]
    );
}

#[test]
fn a_single_group_gives_its_name() {
    assert_eq!(
        names(&clean_mesh(&format!("o box of things \n{POINTS}f 1 2 3\n"))),
        ["box of things"]
    );
}

#[test]
fn groups_and_objects_in_order_of_first_appearance() {
    let obj = format!("{POINTS}g b\no a\nf 1 2 3\ng b\nf 2 3 4\ng mesh\nf 1 3 4\no a\nf 1 2 4\ng nothing\n");
    let animation = clean_mesh(&obj);
    assert_eq!(names(&animation), ["b", "a", "mesh"]);
    let primitive = |part: usize| &animation.meshes[part].primitives[0];
    assert_eq!(
        primitive(0).positions,
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    );
    assert_eq!(primitive(0).triangles, [[0, 1, 2]]);
    assert_eq!(primitive(1).triangles, [[0, 1, 2], [0, 1, 3]]);
}

#[test]
fn a_group_without_name_is_the_default_group() {
    assert_eq!(names(&clean_mesh(&format!("{POINTS}g\nf 1 2 3\n"))), ["default"]);
}

#[test]
fn parts_of_a_cache_have_the_points_they_use_in_ascending_order() {
    let obj = format!("{POINTS}g a\nf 4 2 1\ng b\nf 3 1 4\n");
    let cache = pc2(0.0, 1.0, &frames(2, 4));
    let settings = ImportSettings::default();
    let animation = clean(import_obj_bytes(
        ("m.obj", obj.as_bytes()),
        Some(("m.pc2", &cache)),
        &settings,
    ));
    let primitive = |part: usize| &animation.meshes[part].primitives[0];
    assert_eq!(
        (primitive(0).points.as_slice(), primitive(0).triangles.as_slice()),
        ([0, 1, 3].as_slice(), [[2, 1, 0]].as_slice())
    );
    assert_eq!(
        (primitive(1).points.as_slice(), primitive(1).triangles.as_slice()),
        ([0, 2, 3].as_slice(), [[1, 0, 2]].as_slice())
    );
    assert_eq!(
        primitive(1).positions,
        [[0.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 3.0, 0.5]]
    );
    assert!(animation.parts.iter().all(|part| part.cache == Some(0)));
}
