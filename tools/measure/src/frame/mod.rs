//! What a frame costs against the number of triangles: the update, and rays by fuzzy trees beside rays by a static
//! tree built afresh.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, Table 3.2 (steps, intersections and frame rate relative to a
//! static kd-tree of each frame). Differs: one mesh at several tessellations, single rays, hits and misses together.

mod baked_level;
mod checked_rays;
mod clock;
mod frame_sums;
mod page;
mod report;
mod settings;
mod static_twin;
mod view;

pub use page::page;
pub use report::{COLUMNS, FrameReport, FrameRow, LEGEND, RayCost, TreeCost};
pub use settings::FrameSettings;

use crate::MeasureError;
use baked_level::BakedLevel;
use checked_rays::Place;
use frame_sums::FrameSums;
use rayon::{ThreadPool, ThreadPoolBuilder};
use restpose_bake::{Progress, import::Animation};
use view::View;

/// Bakes the animation at several tessellations and measures frame updates and rays on several numbers of threads.
///
/// Before rays are timed their hits are compared: with the static tree's for all rays, with brute force for a subset,
/// bit for bit. Fuzzy and static trees take turns.
///
/// Guarantee: all numbers but times are the same in every run with the same settings.
///
/// # Errors
/// [`MeasureError`]: settings out of range, a source that does not bake, or results that disagree.
pub fn measure_frame(
    animation: &Animation,
    settings: &FrameSettings,
    progress: &dyn Progress,
) -> Result<FrameReport, MeasureError> {
    settings.check(animation)?;
    let pools = pools(&settings.threads)?;
    let weight = |subdivisions: u32| 1u64 << (2 * subdivisions);
    let total: u64 = (0..=settings.subdivide_max).map(weight).sum();
    progress.stage("measure", total * (settings.frames as u64 + 1));
    let mut rows = Vec::new();
    let mut view: Option<View> = None;
    for subdivisions in 0..=settings.subdivide_max {
        let baked = BakedLevel::new(animation, subdivisions, &pools)?;
        progress.advance(weight(subdivisions));
        let samples = spread(settings.frames, baked.asset.model().samples.len());
        let view = match &view {
            Some(view) => view,
            None => view.insert(View::of(&baked.posed_bounds(&samples)?)),
        };
        let mut sums = FrameSums::default();
        for sample in samples {
            sums.add(&baked.asset, Place { subdivisions, sample }, view, settings, &pools)?;
            progress.advance(weight(subdivisions));
        }
        for (index, pool) in pools.iter().enumerate() {
            rows.push(sums.row(&baked, index, pool, settings)?);
        }
    }
    Ok(FrameReport {
        schema: "restpose.measure.frame.1",
        source: animation.source_name.clone(),
        settings: settings.clone(),
        rows,
    })
}

/// Up to `count` of the indices below `length`, in the middles of equal shares.
fn spread(count: usize, length: usize) -> Vec<usize> {
    let count = count.min(length);
    (0..count).map(|i| (2 * i + 1) * length / (2 * count)).collect()
}

fn pools(threads: &[usize]) -> Result<Vec<ThreadPool>, MeasureError> {
    let pool = |threads: &usize| {
        let pool = ThreadPoolBuilder::new().num_threads(*threads).build();
        pool.map_err(|source| MeasureError::Threads {
            threads: *threads,
            source,
        })
    };
    threads.iter().map(pool).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_all_samples() {
        assert_eq!(spread(4, 100), [12, 37, 62, 87]);
        assert_eq!(spread(1, 1), [0]);
        assert_eq!(spread(5, 2), [0, 1]);
        assert_eq!(spread(3, 0), [0usize; 0]);
    }
}
