//! OBJ files that are refused.

use crate::{cache_builder::TRIANGLE, gltf_builder::errors};
use restpose_bake::import::{ImportSettings, import_obj_bytes};

/// The import must fail with errors at exactly these places. Gives the messages.
fn refused(obj: &str, paths: &[&str]) -> Vec<String> {
    let errors = errors(import_obj_bytes(
        ("x.obj", obj.as_bytes()),
        None,
        &ImportSettings::default(),
    ));
    let found: Vec<_> = errors.iter().map(|fault| fault.path.as_str()).collect();
    assert_eq!(found, paths, "{obj:?}: {errors:?}");
    errors.into_iter().map(|fault| fault.message).collect()
}

#[test]
fn files_without_faces_are_refused() {
    for obj in [
        "",
        "\n",
        "v 0 0 0\n",
        "v 0 0 0\nv 1 0 0\nf 1 2\n",
        "<html>404</html>",
        "f",
    ] {
        assert!(refused(obj, &[""])[0].contains("no faces"), "{obj:?}");
    }
}

#[test]
fn corners_out_of_range_are_refused() {
    for (corner, message) in [
        ("4", "names point 4; the file has 3"),
        ("4294967295", "names point 4294967295; the file has 3"),
        ("4294967297", "names point 4294967297; the limit"),
        ("99999999999999999999", "expected a whole number"),
        ("0", "names point 0"),
        ("-4", "counts back to point -4, but only 3"),
        ("-9223372036854775808", "counts back"),
        ("x", "\"x\" names no point"),
        ("1.5", "expected a whole number"),
        ("/1", "expected a whole number"),
    ] {
        let found = refused(&format!("{TRIANGLE}f 1 2 {corner}\n"), &["line 5"]);
        assert!(found[0].contains(message), "{corner}: {found:?}");
    }
}

#[test]
fn negative_corners_do_not_reach_points_that_come_later() {
    refused("f -3 -2 -1\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", &["line 1"]);
}

#[test]
fn numbers_that_cannot_be_used_are_refused() {
    for (word, message) in [
        ("x", "\"x\"; expected a number"),
        ("0,5", "expected a number"),
        ("nan", "is NaN"),
        ("-inf", "is -inf"),
        ("1e31", "is 1e31; magnitudes above 1e30"),
        ("1e39", "is 1e39; magnitudes above 1e30"),
        ("1e999", "is inf"),
        ("1.#IND", "expected a number"),
    ] {
        let found = refused(&format!("v 0 0 {word}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), &["line 1"]);
        assert!(
            found[0].starts_with("z ") && found[0].contains(message),
            "{word}: {found:?}"
        );
    }
    assert!(refused("v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["line 1"])[0].starts_with("z of a point is missing"));
}

#[test]
fn every_broken_line_is_listed_under_its_number() {
    let obj = "v 0 0 0\nv 1 \\\n x 0\nv 0 1 0\nv 0 1 y\nf 1 2 9\nf 1 2 0\nf 1 2 3\n";
    // Corners that may come later are judged at the end of the file.
    refused(obj, &["line 2", "line 5", "line 7", "line 6"]);
}

#[test]
fn long_words_are_cut_in_messages() {
    let message = &refused(&format!("v {} 0 0\n", "é".repeat(100_000)), &["line 1"])[0];
    assert!(message.len() < 200, "{}", message.len());
}

#[test]
fn faults_without_end_are_counted() {
    let errors = errors(import_obj_bytes(
        ("x.obj", "f 1 2 3\n".repeat(5000).as_bytes()),
        None,
        &ImportSettings::default(),
    ));
    assert_eq!(errors.len(), 1001);
    assert!(errors[1000].message.starts_with("4000 further"));
}
