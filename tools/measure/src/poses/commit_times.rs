use super::{candidate::Candidate, contest::stand};
use crate::{MeasureError, statistics::median};
use restpose_bake::verify::BonePose;
use restpose_runtime::{InstanceId, Scene};
use std::time::Instant;

/// Passes over the poses that are timed: the median of so many is steady.
const PASSES: usize = 9;

/// Microseconds of `commit`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CommitTimes {
    /// In a pose that another came before: median over the poses.
    pub fresh: f64,
    /// How much longer that is than the first candidate's.
    pub fresh_check: f64,
    /// The same where the pose is that of the frame before.
    pub again_check: f64,
}

/// Of one candidate in one pose, per pass.
#[derive(Clone, Default)]
struct Passes {
    fresh: Vec<f64>,
    again: Vec<f64>,
}

/// Commits of every candidate in every pose, in turns, after a pass that is not timed.
pub(super) fn commit_times(candidates: &[Candidate], poses: &[BonePose]) -> Result<Vec<CommitTimes>, MeasureError> {
    let mut scenes: Vec<(Scene, InstanceId)> = candidates
        .iter()
        .map(|candidate| {
            let mut scene = Scene::new();
            let instance = scene.add(&candidate.asset);
            (scene, instance)
        })
        .collect();
    let mut times: Vec<Vec<Passes>> = vec![vec![Passes::default(); candidates.len()]; poses.len()];
    for pass in 0..=PASSES {
        for (pose, times) in poses.iter().zip(&mut times) {
            for ((scene, instance), times) in scenes.iter_mut().zip(times) {
                stand(scene, *instance, pose)?;
                for times in [&mut times.fresh, &mut times.again] {
                    let start = Instant::now();
                    std::hint::black_box(scene.commit());
                    let time = start.elapsed().as_secs_f64() * 1e6;
                    if pass > 0 {
                        times.push(time);
                    }
                }
            }
        }
    }
    let over_poses = |of: &dyn Fn(&[Passes]) -> f64| median(&mut times.iter().map(|own| of(own)).collect::<Vec<f64>>());
    Ok((0..candidates.len())
        .map(|candidate| CommitTimes {
            fresh: over_poses(&|pose| median(&mut pose[candidate].fresh.clone())),
            fresh_check: over_poses(&|pose| median_excess(&pose[candidate].fresh, &pose[0].fresh)),
            again_check: over_poses(&|pose| median_excess(&pose[candidate].again, &pose[0].again)),
        })
        .collect())
}

/// By how much the first is the longer, pass by pass.
fn median_excess(own: &[f64], other: &[f64]) -> f64 {
    median(&mut own.iter().zip(other).map(|(a, b)| a - b).collect::<Vec<f64>>())
}
