use restpose_formats::ModelView;
use std::sync::atomic::AtomicU32;

/// Stretches of a clip.
const STRETCHES: usize = 64;

/// Per stretch of a clip and cluster, the envelope in which a pose was last found there: where to look first. Instances at
/// all phases of a clip share it, and find the right one whoever was there before; what is in it changes no result.
#[derive(Debug, Default)]
pub(crate) struct EnvelopeHints {
    /// Begin of each clip, and stretches per second.
    clips: Vec<(f32, f32)>,
    clusters: usize,
    hints: Vec<AtomicU32>,
}

impl EnvelopeHints {
    pub(crate) fn new(model: &ModelView) -> Self {
        let clips = model.clips.iter().map(|clip| {
            let rate = STRETCHES as f32 / (clip.end_seconds - clip.start_seconds);
            (clip.start_seconds, if rate.is_finite() { rate } else { 0.0 })
        });
        let clusters = model.pose_spaces.len();
        let count = model.clips.len() * STRETCHES * clusters;
        Self {
            clips: clips.collect(),
            clusters,
            hints: std::iter::repeat_with(AtomicU32::default).take(count).collect(),
        }
    }

    /// The stretch of a clip at a time.
    pub(crate) fn stretch(&self, clip: u32, seconds: f32) -> usize {
        let (start, rate) = self.clips[clip as usize];
        // The cast saturates, and makes a NaN zero.
        let place = ((seconds - start) * rate) as usize;
        clip as usize * STRETCHES + place.min(STRETCHES - 1)
    }

    /// The hint of a cluster that has a pose space.
    pub(crate) fn of(&self, stretch: usize, cluster: u32) -> &AtomicU32 {
        &self.hints[stretch * self.clusters + cluster as usize]
    }
}
