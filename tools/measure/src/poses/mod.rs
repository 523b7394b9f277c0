//! What pose spaces and ways to bound their boxes cost, gain and lose.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, Table 3.1 (pose space against fuzzy box area, triangles per leaf
//! and speed) and Table 3.3 (preprocessing and frame rate against tessellation). Differs: single rays, no shading;
//! boxes of envelopes beside sampled ones; clips are measured between their samples, where sampling can lose hits, not in
//! the rest pose.

mod accuracy;
mod candidate;
mod commit_times;
mod contest;
mod page;
mod pose_kind;
mod pose_spaces;
mod report;
mod settings;
mod settled_rays;
mod tessellations;
mod text;
mod thesis;
mod thinned;
mod turns;

pub use page::page;
pub use report::{
    AccuracyFigures, BoundsFigures, CommitFigures, FileFigures, PoseSpaceFigures, PosesReport, RayFigures,
    TessellationFigures,
};
pub use settings::PosesSettings;
pub use thesis::{ThesisPoseSpace, ThesisTessellation};

use crate::{MeasureError, thread_pools::thread_pools};
use contest::Round;
use restpose_bake::{Progress, import::Animation};

/// Bakes a scene in many ways and measures them side by side.
///
/// Before rays are timed their hits are compared: of all files with each other, where two disagree and for a subset with
/// brute force, bit for bit. Files with sampled bounds may miss hits, which are counted.
///
/// Guarantee: all numbers but times are the same in every run with the same settings.
///
/// # Errors
/// [`MeasureError`]: settings out of range, a source that has no clip or does not bake, or a file with envelopes that
/// misses a hit.
pub fn measure_poses(
    animation: &Animation,
    settings: &PosesSettings,
    progress: &dyn Progress,
) -> Result<PosesReport, MeasureError> {
    settings.check(animation)?;
    let poses = settings.poses as u64;
    let levels = u64::from(settings.levels) + 1;
    let per_level = tessellations::FILES + poses * pose_kind::PoseKind::ALL.len() as u64;
    let total = pose_spaces::FILES + poses + levels * per_level + accuracy::FILES + accuracy::TIMES * poses;
    progress.stage("measure", total);
    let pools = thread_pools(&[1])?;
    let round = Round {
        settings,
        pool: &pools[0],
        kind: "",
        progress,
    };
    let (pose_spaces, mut brute_force_rays) = pose_spaces::measure_pose_spaces(animation, &round)?;
    let (mut bounds, mut tessellations) = (Vec::new(), Vec::new());
    for subdivisions in 0..=settings.levels {
        let level = tessellations::measure_tessellation(animation, subdivisions, &round)?;
        bounds.extend(level.bounds);
        tessellations.extend(level.tessellations);
        brute_force_rays += level.brute_force_rays;
    }
    let (accuracy, checked) = accuracy::measure_accuracy(animation, &round)?;
    Ok(PosesReport {
        schema: "restpose.measure.poses.1",
        settings: settings.clone(),
        pose_spaces,
        bounds,
        tessellations,
        accuracy,
        thesis_pose_spaces: thesis::POSE_SPACES,
        thesis_tessellations: thesis::TESSELLATIONS,
        brute_force_rays: brute_force_rays + checked,
    })
}
