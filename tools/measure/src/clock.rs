use crate::checked_rays::CheckedRays;
use crate::{MeasureError, WrongHit, statistics::median};
use restpose_formats::rows::{NONE, SampleRow};
use restpose_runtime::{Asset, Frame, InstanceId, PoseError, Scene};
use std::{sync::Arc, time::Instant};

/// Poses an instance as in a sample.
pub(crate) fn pose(scene: &mut Scene, instance: InstanceId, sample: &SampleRow) -> Result<(), PoseError> {
    match sample.clip {
        NONE => scene.set_default_pose(instance),
        clip => scene.play(instance, clip as usize, sample.seconds),
    }
}

/// Microseconds of frame updates (pose, margins, top level): per pose, those of `passes` passes over all poses, after one
/// pass that is not timed.
pub(crate) fn update_times_us(
    asset: &Arc<Asset>,
    poses: &[SampleRow],
    passes: usize,
) -> Result<Vec<Vec<f64>>, MeasureError> {
    let mut scene = Scene::new();
    let instance = scene.add(asset);
    let mut times = vec![Vec::with_capacity(passes); poses.len()];
    for pass in 0..=passes {
        for (sample, times) in poses.iter().zip(&mut times) {
            let start = Instant::now();
            pose(&mut scene, instance, sample)?;
            std::hint::black_box(scene.commit());
            let time = start.elapsed();
            if pass > 0 {
                times.push(time.as_secs_f64() * 1e6);
            }
        }
    }
    Ok(times)
}

/// Seconds for all rays by fuzzy trees and by the static twin: medians of `repeats`, taken in turns after one round
/// that is not timed and whose hits are compared.
pub(crate) fn trace_seconds(
    frames: [Frame; 2],
    checked: &CheckedRays,
    repeats: u32,
) -> Result<[f64; 2], Box<WrongHit>> {
    let mut hits = vec![None; checked.rays.len()];
    for (frame, name) in frames
        .iter()
        .zip(["a batch by fuzzy trees", "a batch by the static tree"])
    {
        frame.closest_hits(&checked.rays, &mut hits);
        checked.compare(name, &hits)?;
    }
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..repeats {
        for (frame, times) in frames.iter().zip(&mut times) {
            let start = Instant::now();
            frame.closest_hits(&checked.rays, &mut hits);
            times.push(start.elapsed().as_secs_f64());
            std::hint::black_box(&hits);
        }
    }
    Ok(times.map(|mut times| median(&mut times)))
}
