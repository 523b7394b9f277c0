use crate::{
    MeasureError,
    thread_pools::{THREAD_LIMIT, one_and_all},
};
use serde::Serialize;

/// What [`measure_motion`](super::measure_motion) measures.
#[derive(Clone, Debug, Serialize)]
pub struct MotionSettings {
    /// Times of the clip that are measured, spread evenly over its keys: every other one at a key, the others in the
    /// middle between two. Default 25; at least 1; no more than there are keys.
    pub poses: usize,
    /// Thread counts of pictures. Times per ray are those of the first. Default 1 and the current pool's, each at most
    /// 1,024.
    pub threads: Vec<usize>,
    /// Width and height of the picture whose camera rays are traced, pixels. Default 1,024, the thesis's; 1 to 8,192.
    pub picture_side: u32,
    /// Incoherent rays per pose. Default 65,536; at least 1.
    pub random_rays: u32,
    /// Times that each set of rays is timed; the median counts. Default 5; at least 1.
    pub repeats: u32,
    /// Times that the update of each pose is timed; the median counts. Default 40; at least 1.
    pub updates: u32,
    /// Seed of the incoherent rays. Default 1.
    pub seed: u64,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            poses: 25,
            threads: one_and_all(),
            picture_side: 1024,
            random_rays: 1 << 16,
            repeats: 5,
            updates: 40,
            seed: 1,
        }
    }
}

impl MotionSettings {
    pub(super) fn check(&self) -> Result<(), MeasureError> {
        let at_least_one = |name, found| MeasureError::check_setting(name, found, 1, u64::MAX, "1 or more");
        at_least_one("poses", self.poses as u64)?;
        at_least_one("number of thread counts", self.threads.len() as u64)?;
        for threads in &self.threads {
            MeasureError::check_setting("threads", *threads as u64, 1, THREAD_LIMIT as u64, "1 to 1024")?;
        }
        MeasureError::check_setting("picture_side", self.picture_side.into(), 1, 8192, "1 to 8192")?;
        at_least_one("random_rays", self.random_rays.into())?;
        at_least_one("repeats", self.repeats.into())?;
        at_least_one("updates", self.updates.into())
    }
}
