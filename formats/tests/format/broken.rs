//! Models that break one rule each.

use crate::fixture::{Forge, model, read_copy};
use restpose_formats::{FormatError, Model, write};

/// Breaks the fixture and returns the error, which reader and writer must agree on.
pub fn broken(change: impl FnOnce(&mut Model)) -> FormatError {
    let mut model = model();
    change(&mut model);
    let written = write(&model).expect_err("the writer refuses it");
    let read = read_copy(&Forge::of(&model).bytes()).expect_err("the reader refuses it");
    // Compared as text, because NaN is not equal to itself.
    assert_eq!(written.to_string(), read.to_string());
    read
}

/// Declares tests: name, what is broken, pattern of the error.
macro_rules! rules {
    ($($name:ident: $change:expr => $pattern:pat,)+) => {
        $(
            #[test]
            fn $name() {
                let error = $crate::broken::broken($change);
                assert!(matches!(error, $pattern), "{error:?}");
            }
        )+
    };
}

/// A fault of a row.
macro_rules! at {
    ($section:ident, $row:literal, $($fault:tt)+) => {
        Row { section: $section, row: $row, fault: $($fault)+ }
    };
}

pub(crate) use {at, rules};
