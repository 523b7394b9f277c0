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
    // By pose, then by candidate: times of each pass, fresh and again.
    let mut times = vec![vec![[const { Vec::new() }; 2]; candidates.len()]; poses.len()];
    for pass in 0..=PASSES {
        for (pose, times) in poses.iter().zip(&mut times) {
            for ((scene, instance), times) in scenes.iter_mut().zip(times) {
                stand(scene, *instance, pose)?;
                for times in times {
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
    let over_poses =
        |of: &dyn Fn(&[[Vec<f64>; 2]]) -> f64| median(&mut times.iter().map(|own| of(own)).collect::<Vec<f64>>());
    let excess =
        |own: &[f64], first: &[f64]| median(&mut own.iter().zip(first).map(|(a, b)| a - b).collect::<Vec<f64>>());
    Ok((0..candidates.len())
        .map(|candidate| CommitTimes {
            fresh: over_poses(&|pose| median(&mut pose[candidate][0].clone())),
            fresh_check: over_poses(&|pose| excess(&pose[candidate][0], &pose[0][0])),
            again_check: over_poses(&|pose| excess(&pose[candidate][1], &pose[0][1])),
        })
        .collect())
}
