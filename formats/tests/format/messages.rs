//! What an error says: what, where, expected, found, and what to do.

use crate::fixture::{Forge, model, read_copy, wide_model};
use restpose_formats::{Bounds, TreeKind};

fn message(bytes: &[u8]) -> String {
    read_copy(bytes).expect_err("the bytes are wrong").to_string()
}

#[test]
fn another_kind_of_file() {
    assert_eq!(
        message(b"glTF\x02\0\0\0\x18\0\0\0"),
        r#"not a .rpose file: it begins with "glTF\x02\x00\x00\x00\x18\x00", expected "\x8bRPOSE\r\n\x1a\n"; check the path, or bake the source first"#
    );
}

#[test]
fn a_file_cut_short() {
    let bytes = Forge::of(&model()).bytes();
    let expected = bytes.len();
    assert_eq!(
        message(&bytes[..1000]),
        format!("the file is cut short: expected {expected} bytes, found 1000; copy the file again or re-bake it")
    );
}

#[test]
fn another_version() {
    for (major, minor) in [(1, 2), (2, 0)] {
        let bytes = Forge::of(&model()).bytes_with(|header, _| (header.major, header.minor) = (major, minor));
        let expected = format!(
            "format version {major}.{minor} cannot be read; this library reads 1.3; re-bake the source with a matching \
             version of restpose"
        );
        assert_eq!(message(&bytes), expected);
    }
}

#[test]
fn a_damaged_section() {
    let message = message(&Forge::of(&model()).bytes_with(|_, table| table[5].crc32 = 1));
    assert!(
        message.starts_with("section TRIS is damaged: expected checksum 00000001, found "),
        "{message}"
    );
    assert!(message.ends_with("; copy the file again or re-bake it"), "{message}");
}

#[test]
fn a_broken_rule() {
    let mut model = model();
    model.triangles[3].corners[1] = 9;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section TRIS, row 3: `corners` is 9, expected 4 or more and less than 9; the program that wrote it is at \
         fault: re-bake the source"
    );
}

#[test]
fn a_lever_that_is_too_short() {
    let mut model = model();
    model.levers[2].lever[1] = 0.75;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section LEVR, row 2: `lever[1]` is 0.75, expected at least 1 for vertex 7 of the cluster; the program that \
         wrote it is at fault: re-bake the source"
    );
}

#[test]
fn pose_spaces_without_need() {
    let mut model = model();
    model.meta.bounds = Bounds::Sampled;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section PSPC has 3 rows, expected none, for the metadata says that bounds are sampled; the program that wrote \
         it is at fault: re-bake the source"
    );
}

#[test]
fn rows_of_another_kind_of_trees() {
    let mut model = model();
    model.meta.tree = TreeKind::Wide;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section KDND has 8 rows, expected none, for the metadata says that trees are wide; the program that wrote it is \
         at fault: re-bake the source"
    );
}

#[test]
fn a_box_at_a_key_with_its_corners_exchanged() {
    let mut model = wide_model();
    model.key_boxes[3].min[1][0] = 240;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section KBOX, row 3: at place 0 `min` is 240 and `max` 239 on axis 1, expected `min` at most `max`; the program \
         that wrote it is at fault: re-bake the source"
    );
}

#[test]
fn a_box_at_a_key_in_an_empty_place() {
    let mut model = wide_model();
    model.key_boxes[8].max[2][5] = 7;
    assert_eq!(
        message(&Forge::of(&model).bytes()),
        "section KBOX, row 8: at place 5 `min` is 0 and `max` 7 on axis 2, expected zero in an empty place; the program \
         that wrote it is at fault: re-bake the source"
    );
}

#[test]
fn a_damaged_metadata_section() {
    let mut file = Forge::of(&model());
    file.sections[0].1[0] = 7;
    assert_eq!(
        message(&file.bytes()),
        "section META: its codec is 7; this library knows codec 1; re-bake the source with a matching version of \
         restpose"
    );
}
