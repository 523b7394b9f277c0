use crate::{MeasureError, subdivision_limit::check_subdivisions};
use restpose_bake::{BakeSettings, import::Animation};
use restpose_formats::TreeKind;
use serde::Serialize;

/// What [`measure_poses`](super::measure_poses) measures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PosesSettings {
    /// Rays of each kind per pose; fewer where they cost too much, as far outside of a pose space. Camera rays are
    /// those of the largest square picture of no more pixels. Default 4,096; 1 to 2²⁴.
    pub rays: u32,
    /// Poses of each kind. Default 4; 1 to 10,000.
    pub poses: usize,
    /// The mesh is measured subdivided 0 to this many times. Default 2, at most 5.
    pub levels: u32,
    /// Clip of the pose space that holds only one: its name, or its number in the source. Default: the first.
    pub clip: Option<String>,
    /// Times that each turn of rays is timed; the least counts. Default 5; at least 1.
    pub repeats: u32,
    /// Seed of random poses and rays. Default 1.
    pub seed: u64,
    /// What the fuzzy trees are. Default: what a bake takes.
    pub tree: TreeKind,
}

impl Default for PosesSettings {
    fn default() -> Self {
        Self {
            rays: 4_096,
            poses: 4,
            levels: 2,
            clip: None,
            repeats: 5,
            seed: 1,
            tree: BakeSettings::default().tree,
        }
    }
}

impl PosesSettings {
    pub(super) fn check(&self, animation: &Animation) -> Result<(), MeasureError> {
        MeasureError::check_setting("rays", self.rays.into(), 1, 1 << 24, "1 to 16777216")?;
        MeasureError::check_setting("poses", self.poses as u64, 1, 10_000, "1 to 10000")?;
        MeasureError::check_setting("repeats", self.repeats.into(), 1, u64::MAX, "1 or more")?;
        check_subdivisions("levels", self.levels, animation)?;
        if animation.clips.is_empty() {
            return Err(MeasureError::NoClip {
                source_name: animation.source_name.clone(),
            });
        }
        Ok(())
    }
}
