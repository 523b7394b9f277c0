//! One module per command. Each checks its arguments, does its work by the libraries, and gives an answer to print.

pub mod bake;
mod cache_contents;
mod cache_lines;
pub mod demo;
pub mod info;
pub mod measure;
mod measure_frame;
pub mod render;
pub mod validate;
pub mod verify;

use crate::progress::Reporter;

/// What every command works with.
pub struct Context {
    /// Progress and stage times.
    pub reporter: Reporter,
    /// No warnings on stderr.
    pub quiet: bool,
}
