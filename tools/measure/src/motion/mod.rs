//! What motion decomposition costs and gains over one animation: fuzzy trees beside a tree rebuilt for every frame,
//! the clustering by number of clusters, and pictures per second.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, Figure 3.7 (both costs against the number of clusters), Table 3.2
//! (steps, intersections and frame rate against a static kd-tree of each frame) and Figure 3.9 (frame rate over the
//! animation). Differs: single rays, no shading, and half of the poses lie between key frames.

mod cached_parts;
mod clip_times;
mod page;
mod report;
mod settings;

pub use page::page;
pub use report::{
    COLUMNS, CachedPart, ClusteringSeconds, Comparison, FrameRate, Growth, LEGEND, MotionFrame, MotionReport,
    MotionSegment,
};
pub use settings::MotionSettings;

use crate::{
    MeasureError, Place,
    clock::update_times_us,
    peak_memory::peak_memory_bytes,
    posed_rays::{Camera, PosedRays, RaySettings},
    ray_sums::RaySums,
    statistics::median,
    thread_pools::thread_pools,
    view::View,
};
use cached_parts::{cached_parts, clustering_seconds, mean_growth};
use clip_times::{ClipTime, clip_times};
use restpose_bake::{BakeSettings, NoProgress, Progress, bake, import::Animation};
use restpose_formats::{rows::SampleRow, write};
use restpose_runtime::Asset;
use std::{sync::Arc, time::Instant};

/// Bakes the animation and measures its first clip.
///
/// Before rays are timed their hits are compared: with the static tree's for all rays, with brute force for a subset,
/// bit for bit. Fuzzy and static trees take turns.
///
/// Guarantee: all numbers but times and memory are the same in every run with the same settings.
///
/// # Errors
/// [`MeasureError`]: settings out of range, a source that does not move or does not bake, or results that disagree.
pub fn measure_motion(
    animation: &Animation,
    bake_settings: &BakeSettings,
    settings: &MotionSettings,
    progress: &dyn Progress,
) -> Result<MotionReport, MeasureError> {
    settings.check()?;
    let pools = thread_pools(&settings.threads)?;
    progress.stage("bake", 0);
    let start = Instant::now();
    let baked = bake(animation, bake_settings, &NoProgress)?;
    let bake_seconds = start.elapsed().as_secs_f64();
    let bake_peak_bytes = peak_memory_bytes();
    let bytes = write(&baked.model)?;
    let file_bytes = bytes.len() as u64;
    let asset = Arc::new(Asset::from_bytes(&bytes)?);
    drop(bytes);
    if asset.model().clips.is_empty() {
        return Err(MeasureError::NoClip {
            source_name: animation.source_name.clone(),
        });
    }

    let times = clip_times(asset.model(), 0, settings.poses);
    let poses: Vec<SampleRow> = times
        .iter()
        .map(|time| SampleRow {
            clip: 0,
            seconds: time.seconds,
        })
        .collect();
    progress.stage("measure", poses.len() as u64);
    let updates = update_times_us(&asset, &poses, settings.updates as usize)?;
    let cameras = [Camera::Filled, Camera::Fixed(View::of_poses(&asset, &poses)?)];
    let rays = RaySettings {
        cameras: &cameras,
        picture_side: settings.picture_side,
        random_rays: settings.random_rays,
        repeats: settings.repeats,
        seed: settings.seed,
        pools: &pools,
    };
    let parts = cached_parts(&baked.report);
    let mut sums = Sums::default();
    let mut frames = Vec::with_capacity(poses.len());
    for ((time, pose), mut updates) in times.iter().zip(&poses).zip(updates) {
        let place = Place::Time { seconds: time.seconds };
        let posed = PosedRays::measure(&asset, pose, place, &rays)?;
        let frame = frame(time, &posed, median(&mut updates), &parts, &settings.threads);
        sums.add(&posed);
        frames.push(frame);
        progress.advance(1);
    }

    let clustering = clustering_seconds(&baked.report);
    let primary = Comparison::new(&sums.primary.cost(0));
    let segments = || parts.iter().flat_map(|part| &part.segments);
    let mean = |of: fn(&MotionFrame) -> f64| frames.iter().map(of).sum::<f64>() / frames.len() as f64;
    Ok(MotionReport {
        schema: "restpose.measure.motion.1",
        source: animation.source_name.clone(),
        settings: settings.clone(),
        options: baked.model.meta.options.iter().cloned().collect(),
        triangles: baked.report.triangles,
        vertices: baked.report.vertices,
        clusters: baked.report.clusters,
        rest_frame: segments().next().map(|segment| segment.rest_frame),
        clustering_seconds: clustering.entries().iter().map(|(_, seconds)| seconds).sum(),
        clustering,
        bake_seconds,
        bake_peak_bytes,
        file_bytes,
        steps_ratio: primary.steps_ratio,
        intersections_ratio: primary.intersections_ratio,
        time_ratio: primary.time_ratio,
        primary,
        wide: Comparison::new(&sums.wide.cost(0)),
        random: Comparison::new(&sums.random.cost(0)),
        frame_rates: mean_rates(&frames),
        update_us: mean(|frame| frame.update_us),
        static_build_ms: mean(|frame| frame.static_build_ms),
        brute_force_rays: sums.brute_force_rays(),
        growth: mean_growth(segments().map(|segment| segment.growth.as_slice())),
        parts,
        frames,
    })
}

/// Over all poses.
#[derive(Default)]
struct Sums {
    primary: RaySums,
    wide: RaySums,
    random: RaySums,
}

impl Sums {
    fn add(&mut self, posed: &PosedRays) {
        for (sum, own) in [&mut self.primary, &mut self.wide].into_iter().zip(&posed.cameras) {
            *sum += own;
        }
        self.random += &posed.random;
    }

    fn brute_force_rays(&self) -> u64 {
        self.primary.brute_force_rays + self.wide.brute_force_rays + self.random.brute_force_rays
    }
}

fn frame(time: &ClipTime, posed: &PosedRays, update_us: f64, parts: &[CachedPart], threads: &[usize]) -> MotionFrame {
    let [filled, wide] = [0, 1].map(|camera: usize| &posed.cameras[camera]);
    let primary = Comparison::new(&filled.cost(0));
    let segments = parts
        .iter()
        .map(|part| &part.segments)
        .find(|segments| !segments.is_empty());
    let covers = |segment: &MotionSegment| time.cache_frame.is_some_and(|frame| frame <= segment.key_last as f64);
    let segment = segments.and_then(|segments| segments.iter().position(covers));
    let rate = |(pool, threads): (usize, &usize)| {
        let cost = filled.cost(pool);
        let seconds = |mrays: f64| cost.rays as f64 / mrays / 1e6;
        FrameRate {
            threads: *threads,
            fuzzy: 1.0 / (seconds(cost.ours.mrays) + update_us / 1e6),
            static_traced: 1.0 / seconds(cost.twin.mrays),
            static_built: 1.0 / (seconds(cost.twin.mrays) + posed.static_build_seconds),
        }
    };
    MotionFrame {
        seconds: time.seconds,
        at_key: time.at_key,
        cache_frame: time.cache_frame,
        segment,
        clusters: posed.stats.clusters,
        clusters_without_inverse: posed.stats.clusters_without_inverse,
        rest_frame: segments
            .zip(segment)
            .map(|(segments, place)| segments[place].rest_frame),
        steps_ratio: primary.steps_ratio,
        intersections_ratio: primary.intersections_ratio,
        time_ratio: primary.time_ratio,
        primary,
        wide: Comparison::new(&wide.cost(0)),
        random: Comparison::new(&posed.random.cost(0)),
        frame_rates: threads.iter().enumerate().map(rate).collect(),
        update_us,
        static_build_ms: posed.static_build_seconds * 1e3,
        static_box_area: posed.static_box_area,
    }
}

/// Pictures of all frames over the time that they take together.
fn mean_rates(frames: &[MotionFrame]) -> Vec<FrameRate> {
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let mean = |(place, rate): (usize, &FrameRate)| {
        let mean = |of: fn(&FrameRate) -> f64| {
            let seconds: f64 = frames.iter().map(|frame| 1.0 / of(&frame.frame_rates[place])).sum();
            frames.len() as f64 / seconds
        };
        FrameRate {
            threads: rate.threads,
            fuzzy: mean(|rate| rate.fuzzy),
            static_traced: mean(|rate| rate.static_traced),
            static_built: mean(|rate| rate.static_built),
        }
    };
    first.frame_rates.iter().enumerate().map(mean).collect()
}
