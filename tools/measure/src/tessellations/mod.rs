//! What a frame costs against the number of triangles: the update, and rays by fuzzy trees beside rays by a static
//! tree built afresh.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, Table 3.2 (steps, intersections and frame rate relative to a
//! static kd-tree of each frame). Differs: one mesh at several tessellations, single rays, hits and misses together.

mod baked_level;
mod frame_sums;
mod page;
mod report;
mod settings;

pub use page::page;
pub use report::{COLUMNS, LEGEND, TessellationRow, TessellationsReport};
pub use settings::TessellationsSettings;

use crate::{
    MeasureError, Place,
    posed_rays::{Camera, PosedRays, RaySettings},
    spread::spread,
    thread_pools::thread_pools,
    view::View,
};
use baked_level::BakedLevel;
use frame_sums::FrameSums;
use restpose_bake::{Progress, import::Animation};
use restpose_formats::rows::SampleRow;

/// Bakes the animation at several tessellations and measures frame updates and rays on several numbers of threads.
///
/// Before rays are timed their hits are compared: with the static tree's for all rays, with brute force for a subset,
/// bit for bit. Fuzzy and static trees take turns.
///
/// Guarantee: all numbers but times are the same in every run with the same settings.
///
/// # Errors
/// [`MeasureError`]: settings out of range, a source that does not bake, or results that disagree.
pub fn measure_tessellations(
    animation: &Animation,
    settings: &TessellationsSettings,
    progress: &dyn Progress,
) -> Result<TessellationsReport, MeasureError> {
    settings.check(animation)?;
    let pools = thread_pools(&settings.threads)?;
    let weight = |subdivisions: u32| 1u64 << (2 * subdivisions);
    let total: u64 = (0..=settings.subdivide_max).map(weight).sum();
    progress.stage("measure", total * (settings.frames as u64 + 1));
    let mut rows = Vec::new();
    let mut cameras = Vec::new();
    for subdivisions in 0..=settings.subdivide_max {
        let baked = BakedLevel::new(animation, subdivisions, settings.tree, &pools)?;
        progress.advance(weight(subdivisions));
        let all = baked.asset.model().samples;
        let samples = spread(settings.frames, all.len());
        if cameras.is_empty() {
            let poses: Vec<SampleRow> = samples.iter().map(|sample| all[*sample]).collect();
            cameras.push(Camera::Fixed(View::of_poses(&baked.asset, &poses)?));
        }
        let rays = RaySettings {
            cameras: &cameras,
            picture_side: settings.picture_side,
            random_rays: settings.random_rays,
            repeats: settings.repeats,
            seed: settings.seed,
            pools: &pools,
        };
        let mut sums = FrameSums::default();
        for sample in samples {
            let place = Place::Sample { subdivisions, sample };
            sums.add(&PosedRays::measure(&baked.asset, &all[sample], place, &rays)?);
            progress.advance(weight(subdivisions));
        }
        for (index, pool) in pools.iter().enumerate() {
            rows.push(sums.row(&baked, index, pool, settings)?);
        }
    }
    Ok(TessellationsReport {
        schema: "restpose.measure.tessellations.2",
        source: animation.source_name.clone(),
        settings: settings.clone(),
        rows,
    })
}
