use super::{
    PoseSpace, SampledPose,
    joint_ranges::{Range, joint_ranges, joints},
    rotation::{from_vector, uniform},
};
use crate::{BakeError, BakeSettings, Progress};
use rayon::prelude::*;
use restpose_formats::Model;
use restpose_runtime::{Pose, PoseEvaluator};

/// The random poses of a pose space, evaluated on all cores; none where the pose space has no random poses, or neither
/// joints turn nor morph weights change in them.
///
/// Every joint is turned in its own axes from where it is without any clip; morph weights are uniform between the extremes
/// of `clip_poses`, the model's samples evaluated. Pose `k` depends on the seed and `k` alone, not on the count or on
/// threads.
///
/// # Errors
/// [`BakeError::JointLimits`], [`BakeError::PoseOverflow`].
pub(crate) fn random_poses(
    model: &Model,
    settings: &BakeSettings,
    clip_poses: &[SampledPose],
    progress: &dyn Progress,
) -> Result<Vec<SampledPose>, BakeError> {
    let joints = joints(model);
    let turns: Vec<Turn> = match &settings.pose_space {
        PoseSpace::Clips | PoseSpace::Clip(_) => return Ok(Vec::new()),
        PoseSpace::Arbitrary => joints.iter().map(|_| Turn::Any).collect(),
        PoseSpace::Limits(limits) => {
            let ranges = joint_ranges(model, &joints, limits)?;
            ranges.into_iter().map(Turn::Within).collect()
        }
    };
    let weights = weight_ranges(model, clip_poses);
    if turns.is_empty() && weights.iter().all(|[least, greatest]| least == greatest) {
        return Ok(Vec::new());
    }
    let mut turn_of_node = vec![None; model.nodes.len()];
    for (joint, turn) in joints.iter().zip(turns) {
        turn_of_node[joint.node] = Some(turn);
    }

    let mut seeds = fastrand::Rng::with_seed(settings.seed);
    let seeds: Vec<u64> = (0..settings.random_samples()).map(|_| seeds.u64(..)).collect();
    progress.stage("random poses", seeds.len() as u64);
    let view = model.view();
    seeds
        .par_iter()
        .enumerate()
        .map_init(PoseEvaluator::default, |evaluator, (number, seed)| {
            let mut random = fastrand::Rng::with_seed(*seed);
            let mut pose = Pose::default();
            evaluator.evaluate_with(&view, None, 0.0, &mut pose, |node, local| {
                if let Some(turn) = &turn_of_node[node] {
                    local.turn(turn.draw(&mut random));
                }
            });
            for (weight, [least, greatest]) in pose.morph_weights.iter_mut().zip(&weights) {
                *weight = (f64::from(*least) + random.f64() * (f64::from(*greatest) - f64::from(*least))) as f32;
            }
            let sampled = SampledPose::new(model, pose, || format!("in random pose {number}"))?;
            progress.advance(1);
            Ok(sampled)
        })
        .collect()
}

/// How a joint is turned.
#[derive(Clone)]
enum Turn {
    Any,
    Within(Range),
}

impl Turn {
    /// A uniform rotation after any fixed one is uniform, so both start from the joint's own.
    fn draw(&self, random: &mut fastrand::Rng) -> [f64; 4] {
        match self {
            Self::Any => uniform(random),
            Self::Within(ranges) => {
                from_vector(ranges.map(|[least, greatest]| least + random.f64() * (greatest - least)))
            }
        }
    }
}

/// Least and greatest weight of each morph target.
fn weight_ranges(model: &Model, poses: &[SampledPose]) -> Vec<[f32; 2]> {
    let defaults = model.morph_targets.iter().map(|target| target.default_weight);
    let mut out: Vec<[f32; 2]> = defaults.map(|weight| [weight; 2]).collect();
    for pose in poses {
        for (range, weight) in out.iter_mut().zip(&pose.morph_weights) {
            *range = [range[0].min(*weight), range[1].max(*weight)];
        }
    }
    out
}
