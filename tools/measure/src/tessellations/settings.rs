use crate::{
    MeasureError,
    subdivision_limit::check_subdivisions,
    thread_pools::{THREAD_LIMIT, one_and_all},
};
use restpose_bake::{BakeSettings, import::Animation};
use restpose_formats::TreeKind;
use serde::Serialize;

/// What [`measure_tessellations`](super::measure_tessellations) measures.
#[derive(Clone, Debug, Serialize)]
pub struct TessellationsSettings {
    /// The mesh is measured subdivided 0 to this many times. Default 3, at most 5.
    pub subdivide_max: u32,
    /// Thread counts, a row each. Default 1 and the current pool's, each at most 1,024.
    pub threads: Vec<usize>,
    /// Posed frames whose rays are traced, spread evenly over the samples. Default 4; at least 1; no more than there
    /// are samples.
    pub frames: usize,
    /// Width and height of the picture whose camera rays are traced, pixels. Default 512, 1 to 8,192.
    pub picture_side: u32,
    /// Incoherent rays per frame. Default 65,536; at least 1.
    pub random_rays: u32,
    /// Times that each set of rays is timed. Default 5; at least 1.
    pub repeats: u32,
    /// Frame updates that are timed, rounded up to whole passes over the samples. Default 4,000; at least 1.
    pub updates: u32,
    /// Seed of the incoherent rays. Default 1.
    pub seed: u64,
    /// What the fuzzy trees are, and the static ones. Default: what a bake takes.
    pub tree: TreeKind,
}

impl Default for TessellationsSettings {
    fn default() -> Self {
        Self {
            subdivide_max: 3,
            threads: one_and_all(),
            frames: 4,
            picture_side: 512,
            random_rays: 1 << 16,
            repeats: 5,
            updates: 4_000,
            seed: 1,
            tree: BakeSettings::default().tree,
        }
    }
}

impl TessellationsSettings {
    pub(super) fn check(&self, animation: &Animation) -> Result<(), MeasureError> {
        let at_least_one = |name, found| MeasureError::check_setting(name, found, 1, u64::MAX, "1 or more");
        check_subdivisions("subdivide_max", self.subdivide_max, animation)?;
        for threads in &self.threads {
            MeasureError::check_setting("threads", *threads as u64, 1, THREAD_LIMIT as u64, "1 to 1024")?;
        }
        at_least_one("frames", self.frames as u64)?;
        MeasureError::check_setting("picture_side", self.picture_side.into(), 1, 8192, "1 to 8192")?;
        at_least_one("random_rays", self.random_rays.into())?;
        at_least_one("repeats", self.repeats.into())?;
        at_least_one("updates", self.updates.into())
    }
}
