//! Fuzzy boxes: where a triangle can be in the local space of a cluster.
//!
//! Boxes around samples are the smallest, and nothing is known of other poses. Boxes by envelopes hold for every pose that
//! lies in one, and the runtime tells by how much another leaves them. How many envelopes is a trade: one is the loosest and
//! spans everything between its poses, as many as poses are boxes around samples again, with a margin to the nearest one.
//! Measured (`restpose measure poses`, least and greatest of three characters at 0.6k to 299k triangles; area and speed of
//! rays relative to boxes around samples; commit is what a frame takes longer, in the pose of the frame before and in
//! another pose of the clips):
//!
//! | envelopes | area | speed in clips | commit, µs | speed in blends |
//! |---|---|---|---|---|
//! | 1 | 1.1 to 3.2 | 0.32 to 0.95 | 2 to 14, 2 to 16 | 0.44 to 0.93 |
//! | 16 | 1.0 to 1.4 | 0.70 to 1.03 | 5 to 8, 8 to 17 | 0.62 to 0.99 |
//! | 64 | 1.0 to 1.06 | 0.96 to 1.03 | 4 to 8, 10 to 27 | 0.61 to 1.06 |
//!
//! With 1024 the speed in clips is that of samples, and the file grows by up to 5 MB. 64 keep the contract for the fewest
//! percent, so they are the default.

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
