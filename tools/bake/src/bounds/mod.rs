//! Fuzzy boxes: where a triangle can be in the local space of a cluster.

mod fuzzy_box;
mod vertex_track;

pub(crate) use fuzzy_box::{FrameTrack, FuzzyBox};
pub(crate) use vertex_track::vertex_track;
