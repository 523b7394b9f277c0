use restpose_formats::{ModelView, rows::STRETCHES};
use std::sync::atomic::AtomicU32;

/// Per row of clip bounds, a stretch of a clip or the pose without any, and cluster, the envelope in which a pose was last
/// found there: where to look first. Instances at all phases of a clip share it, and find the right one whoever was there
/// before; what is in it changes no result.
#[derive(Debug, Default)]
pub(crate) struct EnvelopeHints {
    clusters: usize,
    hints: Vec<AtomicU32>,
}

impl EnvelopeHints {
    pub(crate) fn new(model: &ModelView) -> Self {
        let clusters = model.pose_spaces.len();
        let count = (model.clips.len() * STRETCHES + 1) * clusters;
        Self {
            clusters,
            hints: std::iter::repeat_with(AtomicU32::default).take(count).collect(),
        }
    }

    /// The hint of a cluster that has a pose space. `row` is that of clip bounds, whether or not the file has any.
    pub(crate) fn of(&self, row: usize, cluster: u32) -> &AtomicU32 {
        &self.hints[row * self.clusters + cluster as usize]
    }
}
