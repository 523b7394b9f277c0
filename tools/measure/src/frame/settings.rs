use super::{RayKind, contestants::strategy_names};
use crate::{
    MeasureError,
    thread_pools::{THREAD_LIMIT, one_and_all},
};
use serde::Serialize;

/// What [`measure_frame`](super::measure_frame) measures.
#[derive(Clone, Debug, Serialize)]
pub struct FrameSettings {
    /// Names out of [`strategy_names`]. Default: all.
    pub strategies: Vec<String>,
    /// Thread counts, each at most 1,024. Default 1 and the current pool's.
    pub threads: Vec<usize>,
    /// Rays of a frame, each at most 16,777,216; pictures have about as many. Default 1, 10, 100 and so on to a million.
    pub rays: Vec<u32>,
    /// Kinds of rays. Default: all but segments.
    pub ray_kinds: Vec<RayKind>,
    /// Poses that frames go through, one after the other, evenly spread over the first clip. Default 8; at least 1.
    pub poses: usize,
    /// Who makes the palettes. Default: the frame does.
    pub palettes: Palettes,
    /// Seconds of frames of one kind, after which a contestant has no further turn. A turn is a frame of every pose.
    /// Default 0.25; at least 0.
    pub seconds: f64,
    /// Most turns of a contestant with one kind of frames. Default 100; at least 1.
    pub turns: u32,
    /// Seed of the random rays. Default 1.
    pub seed: u64,
}

/// Where a frame's palettes, morph weights and frames of vertex caches come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Palettes {
    /// Clips are evaluated within the frame.
    Evaluated,
    /// They are there, from an animation system say, and are handed over.
    Given,
}

impl Default for FrameSettings {
    fn default() -> Self {
        Self {
            strategies: strategy_names().into_iter().map(str::to_owned).collect(),
            threads: one_and_all(),
            rays: (0..=6).map(|decade| 10u32.pow(decade)).collect(),
            ray_kinds: vec![RayKind::Random, RayKind::Primary, RayKind::CloseUp],
            poses: 8,
            palettes: Palettes::Evaluated,
            seconds: 0.25,
            turns: 100,
            seed: 1,
        }
    }
}

impl FrameSettings {
    pub(super) fn check(&self) -> Result<(), MeasureError> {
        let check = MeasureError::check_setting;
        for threads in &self.threads {
            check("threads", *threads as u64, 1, THREAD_LIMIT as u64, "1 to 1024")?;
        }
        for rays in &self.rays {
            check("rays", u64::from(*rays), 1, 1 << 24, "1 to 16777216")?;
        }
        check("poses", self.poses as u64, 1, 10_000, "1 to 10000")?;
        check("turns", self.turns.into(), 1, u64::MAX, "1 or more")?;
        let known = strategy_names();
        match self.strategies.iter().find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(MeasureError::UnknownStrategy {
                name: name.clone(),
                known: known.join(", "),
            }),
        }
    }

    pub(super) fn chosen(&self, strategy: &str) -> bool {
        self.strategies.iter().any(|name| name == strategy)
    }
}
