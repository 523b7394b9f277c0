//! Parts that a vertex cache moves: clusters, tracks, stored positions, fuzzy boxes between keys, time segments, trees,
//! boxes of their nodes at keys.
//!
//! Decomposing the motion itself is `motion::keyframed`; here its clusters become what a file holds.

mod homes;
mod key_box_rows;
mod key_boxes;
mod key_track;
mod part;
mod report;
mod rows;
mod segment;
mod split;
mod stored_positions;
mod structure;

pub(crate) use part::{add_caches, cache_row};
pub use report::{CacheReport, ExpectedFrame, SegmentReport};
