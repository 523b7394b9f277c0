use crate::fixture::{model, read_copy};
use restpose_formats::write;
use std::path::PathBuf;

/// The fixture as version 1.2 wrote it.
pub const V1_2: &[u8] = include_bytes!("../golden/v1.2.rpose");

#[test]
fn the_golden_file_of_version_1_2_opens_and_equals_the_fixture() {
    assert_eq!(read_copy(V1_2), Ok(model()));
}

#[test]
fn the_golden_file_of_version_1_2_is_rewritten_byte_for_byte() {
    let read_back = read_copy(V1_2).expect("the golden file reads");
    assert!(write(&read_back).as_deref() == Ok(V1_2));
}

/// Run by hand, and only while version 1.2 is unreleased: a released version's golden file never changes.
#[test]
#[ignore = "writes the golden file"]
fn write_golden_file() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/v1.2.rpose");
    std::fs::write(path, write(&model()).expect("the fixture is valid")).expect("writable");
}
