//! What is in a baked `.rpose` file, and the checks that let a reader trust it.
//!
//! [`Model`] owns a file's contents, [`ModelView`] borrows them; [`write()`] and [`read()`] are the only doors between
//! them and bytes. The text for readers in other languages is `FORMAT.md` beside this crate.
//!
//! This crate has no threads, clocks or file handles: bytes in, bytes out.

mod aligned_bytes;
mod check;
mod error;
pub mod geom;
mod header;
mod meta;
mod meta_codec;
mod model;
mod read;
mod row_fault;
pub mod rows;
mod section;
mod section_table;
mod version;
mod write;

pub use aligned_bytes::AlignedBytes;
pub use error::FormatError;
pub use header::{FEATURE_SAMPLED_BOUNDS, Header, KNOWN_REQUIRED_FEATURES, MAGIC};
pub use meta::{Bounds, Meta, TreeKind};
pub use meta_codec::{META_LIMIT, MetaFault};
pub use model::{Hashes, Model, ModelView};
pub use read::{read, read_written};
pub use row_fault::RowFault;
pub use section::{SECTION_ALIGN, SectionCode, SectionEntry, SectionKind};
pub use version::FormatVersion;
pub use write::write;
