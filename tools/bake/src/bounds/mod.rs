//! Fuzzy boxes: where a triangle can be in the local space of a cluster.

mod affine_fit;
mod cluster_space;
mod envelope_boxes;
mod enveloped;
mod fuzzy_box;
mod movers;
mod nearest_groups;
mod pivot;
mod vertex_track;

pub(crate) use cluster_space::{ClusterSpace, Poses};
pub(crate) use enveloped::bound_by_envelopes;
pub(crate) use fuzzy_box::{FrameTrack, FuzzyBox};
pub(crate) use vertex_track::vertex_track;
