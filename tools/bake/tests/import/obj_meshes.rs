//! Points and faces of OBJ files.

use crate::cache_builder::{TRIANGLE, clean_mesh, warned};
use restpose_bake::import::{Animation, ImportSettings, Local, import_obj_bytes};

fn triangles(obj: &str) -> Vec<[u32; 3]> {
    let animation = clean_mesh(obj);
    assert_eq!(animation.meshes.len(), 1);
    animation.meshes[0].primitives[0].triangles.clone()
}

#[test]
fn a_mesh_is_static_on_one_node() {
    let animation = clean_mesh(TRIANGLE);
    assert_eq!(
        (animation.nodes.len(), animation.meshes.len(), animation.parts.len()),
        (1, 1, 1)
    );
    let identity = Local::Trs {
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    assert_eq!((animation.nodes[0].local, animation.nodes[0].parent), (identity, None));
    let primitive = &animation.meshes[0].primitives[0];
    assert_eq!(primitive.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(primitive.triangles, [[0, 1, 2]]);
    assert_eq!((primitive.source_primitive, primitive.points.len()), (0, 0));
    let Animation {
        clips,
        caches,
        skins,
        import_options,
        ..
    } = animation;
    assert!(clips.is_empty() && caches.is_empty() && skins.is_empty() && import_options.is_empty());
}

#[test]
fn numbers_are_rounded_to_the_nearest_f32() {
    let obj = "v 0.1 -1.5e-20 +3.4e5\nv 1e20 1e-50 .5\nv 16777217 5. -0\nf 1 2 3\n";
    let expected = [[0.1, -1.5e-20, 3.4e5], [1e20, 0.0, 0.5], [16_777_216.0, 5.0, -0.0]];
    assert_eq!(clean_mesh(obj).meshes[0].primitives[0].positions, expected);
}

#[test]
fn weights_and_colours_behind_a_point_are_ignored() {
    assert_eq!(triangles("v 0 0 0 1\nv 1 0 0 0.5 0.5 x\nv 0 1 0\nf 1 2 3"), [[0, 1, 2]]);
}

#[test]
fn every_form_of_corner() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    for face in [
        "3 1 2",
        "3/1 1/1 2/1",
        "3//1 1//1 2//1",
        "3/1/1 1/1/1 2/1/1",
        "3/ 1/9/-9 2/x",
        "-1 -3 -2",
    ] {
        assert_eq!(triangles(&format!("{points}f {face}\n")), [[2, 0, 1]], "{face}");
    }
}

#[test]
fn negative_corners_count_back_from_the_face() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -3 -2 -1\n";
    assert_eq!(triangles(obj), [[0, 1, 2], [1, 2, 3]]);
}

#[test]
fn faces_may_come_before_their_points() {
    assert_eq!(triangles("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"), [[0, 1, 2]]);
}

#[test]
fn polygons_become_fans_in_file_order() {
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0 0\n";
    let obj = format!("{points}f 2 3 4 5 1\nf 1 2 3\nf 4 3 2 1\n");
    assert_eq!(
        triangles(&obj),
        [[1, 2, 3], [1, 3, 4], [1, 4, 0], [0, 1, 2], [3, 2, 1], [3, 1, 0]]
    );
}

#[test]
fn triangles_without_area_are_kept() {
    assert_eq!(
        triangles("v 0 0 0\nv 1 0 0\nf 1 1 2\nf 1 2 1 2\n"),
        [[0, 0, 1], [0, 1, 0], [0, 0, 1]]
    );
}

#[test]
fn equal_points_are_not_welded_and_unused_ones_are_left_out() {
    let animation = clean_mesh("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 8 8 8\nv 0 0 0\nf 5 3 2\n");
    let primitive = &animation.meshes[0].primitives[0];
    assert_eq!(primitive.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]]);
    assert_eq!(primitive.triangles, [[2, 1, 0]]);
}

#[test]
fn comments_continued_lines_and_any_white_space() {
    let obj = "\u{FEFF}# C:\\\r\n\tv 0 0 0 # one\r\nv \\\r\n 1 0 \\\r\n 0\r\n\r\nv\t0 1 0\r\nf 1 \\\n 2 3";
    assert_eq!(triangles(obj), [[0, 1, 2]]);
}

#[test]
fn other_statements_are_skipped() {
    let others = "mtllib x.mtl\nusemtl y\ns off\nvt 0\nvn x\nvp 0 0\nl 1 2\np 1\nwhat ever\n\0\u{1}\n";
    assert_eq!(triangles(&format!("{others}{TRIANGLE}{others}")), [[0, 1, 2]]);
}

#[test]
fn faces_of_fewer_than_three_corners_are_skipped_with_a_warning() {
    let obj = format!("{TRIANGLE}f 1 2\n");
    let result = import_obj_bytes(("x.obj", obj.as_bytes()), None, &ImportSettings::default());
    let (animation, fault) = warned(result);
    assert_eq!(fault.path, "line 5");
    assert_eq!(animation.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
}

#[test]
fn curves_surfaces_and_calls_are_skipped_with_one_warning() {
    let obj = format!("{TRIANGLE}cstype bezier\ndeg 3\nsurf 0 1 0 1 1 2 3\ncall other.obj\ncurv 0 1 1 2\nend\n");
    let result = import_obj_bytes(("x.obj", obj.as_bytes()), None, &ImportSettings::default());
    assert_eq!(warned(result).1.path, "line 7");
}
