//! Models that break one rule each.

use crate::fixture::{Forge, model, read_copy, wide_model};
use restpose_formats::{FormatError, Model, write};

/// Breaks the fixture and returns the error, which reader and writer must agree on.
pub fn broken(change: impl FnOnce(&mut Model)) -> FormatError {
    error_of(model(), change)
}

/// The same of the fixture with wide trees.
pub fn broken_wide(change: impl FnOnce(&mut Model)) -> FormatError {
    error_of(wide_model(), change)
}

fn error_of(mut model: Model, change: impl FnOnce(&mut Model)) -> FormatError {
    change(&mut model);
    let written = write(&model).expect_err("the writer refuses it");
    let read = read_copy(&Forge::of(&model).bytes()).expect_err("the reader refuses it");
    // Compared as text, because NaN is not equal to itself.
    assert_eq!(written.to_string(), read.to_string());
    read
}

/// Declares tests: the function that breaks a fixture, then name, what is broken, pattern of the error.
macro_rules! rules_of {
    ($broken:ident; $($name:ident: $change:expr => $pattern:pat,)+) => {
        $(
            #[test]
            fn $name() {
                let error = $crate::broken::$broken($change);
                assert!(matches!(error, $pattern), "{error:?}");
            }
        )+
    };
}

/// Declares tests that break the fixture.
macro_rules! rules {
    ($($rules:tt)+) => {
        $crate::broken::rules_of! { broken; $($rules)+ }
    };
}

/// A fault of a row.
macro_rules! at {
    ($section:ident, $row:literal, $($fault:tt)+) => {
        Row { section: $section, row: $row, fault: $($fault)+ }
    };
}

pub(crate) use {at, rules, rules_of};
