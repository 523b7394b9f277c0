use crate::fixture::{model, read_copy, wide_model};
use restpose_formats::{Model, write};
use std::path::PathBuf;

/// The fixture as version 1.3 wrote it.
pub const V1_3: &[u8] = include_bytes!("../golden/v1.3.rpose");

/// The fixture with wide trees as version 1.3 wrote it.
pub const V1_3_WIDE: &[u8] = include_bytes!("../golden/v1.3_wide.rpose");

fn golden() -> [(&'static str, &'static [u8], Model); 2] {
    [
        ("v1.3.rpose", V1_3, model()),
        ("v1.3_wide.rpose", V1_3_WIDE, wide_model()),
    ]
}

#[test]
fn the_golden_files_of_version_1_3_open_and_equal_the_fixtures() {
    for (name, bytes, model) in golden() {
        assert_eq!(read_copy(bytes), Ok(model), "{name}");
    }
}

#[test]
fn the_golden_files_of_version_1_3_are_rewritten_byte_for_byte() {
    for (name, bytes, _) in golden() {
        let read_back = read_copy(bytes).expect("the golden file reads");
        assert!(write(&read_back).as_deref() == Ok(bytes), "{name}");
    }
}

/// Run by hand, and only while version 1.3 is unreleased: a released version's golden files never change.
#[test]
#[ignore = "writes the golden files"]
fn write_golden_files() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    for (name, _, model) in golden() {
        std::fs::write(folder.join(name), write(&model).expect("the fixture is valid")).expect("writable");
    }
}
