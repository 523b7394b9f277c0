//! What is in a baked `.rpose` file, and the checks that let a reader trust it.
//!
//! [`Model`] owns a file's contents, [`ModelView`] borrows them; [`write`] and [`read`] are the only doors between
//! them and bytes. The text for readers in other languages is `FORMAT.md` beside this crate.
//!
//! This crate has no threads, clocks or file handles: bytes in, bytes out.

pub mod geom;
mod meta;
mod model;
pub mod rows;

pub use meta::{Bounds, Meta};
pub use model::{Hashes, Model, ModelView};
