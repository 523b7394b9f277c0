use super::{
    LimitSettings,
    joint_limits::JointLimitsError,
    rotation::{between, vector_of},
};
use rayon::prelude::*;
use restpose_formats::{
    Model, ModelView,
    rows::{NONE, SampleRow},
};
use restpose_runtime::{NodeLocal, Pose, PoseEvaluator};

/// Samples that one task looks at.
const SAMPLES_PER_TASK: usize = 256;

/// A joint: a node that carries some bone of a skin.
pub(crate) struct Joint<'a> {
    /// Node row.
    pub node: usize,
    /// Node's name.
    pub name: &'a str,
}

/// Every joint once, by node row.
pub(crate) fn joints(model: &Model) -> Vec<Joint<'_>> {
    let bones = model.bones.iter().zip(&model.meta.bone_names);
    let mut out: Vec<Joint> = bones
        .filter(|(bone, _)| bone.source_skin != NONE)
        .map(|(bone, name)| Joint {
            node: bone.node as usize,
            name,
        })
        .collect();
    out.sort_by_key(|joint| joint.node);
    out.dedup_by_key(|joint| joint.node);
    out
}

/// Least and greatest component of a joint's rotation vector about each of its axes, radians.
pub(crate) type Range = [[f64; 2]; 3];

/// The range of each joint: what the limits say of its name, else what the samples reach and the slack around it.
///
/// Beyond half a turn from its rotation without any clip, a joint's rotation vector jumps to the other side; the range then
/// contains both.
///
/// # Errors
/// [`JointLimitsError::Unknown`].
pub(crate) fn joint_ranges(
    model: &Model,
    joints: &[Joint],
    settings: &LimitSettings,
) -> Result<Vec<Range>, JointLimitsError> {
    let listed = &settings.joints;
    let unknown: Vec<String> = listed
        .joints
        .keys()
        .filter(|name| joints.iter().all(|joint| joint.name != *name))
        .cloned()
        .collect();
    if !unknown.is_empty() {
        let mut known: Vec<String> = joints.iter().map(|joint| joint.name.to_owned()).collect();
        known.sort_unstable();
        known.dedup();
        return Err(JointLimitsError::Unknown {
            file: listed.source.clone(),
            unknown,
            known,
        });
    }
    let reached = reached(model, joints);
    let slack = settings.slack_deg;
    let range = |(joint, reached): (&Joint, Range)| {
        let degrees = match listed.joints.get(joint.name) {
            Some(range) => range.axes(),
            None => reached.map(|[least, greatest]| {
                [
                    (least.to_degrees() - slack).max(-180.0),
                    (greatest.to_degrees() + slack).min(180.0),
                ]
            }),
        };
        degrees.map(|range| range.map(f64::to_radians))
    };
    Ok(joints.iter().zip(reached).map(range).collect())
}

/// What the joints reach in the model's samples.
fn reached(model: &Model, joints: &[Joint]) -> Vec<Range> {
    let view = model.view();
    let start = locals(
        &view,
        joints,
        &mut PoseEvaluator::default(),
        &SampleRow {
            clip: NONE,
            seconds: 0.0,
        },
    );
    let still = vec![[[0.0; 2]; 3]; joints.len()];
    model
        .samples
        .par_chunks(SAMPLES_PER_TASK)
        .map_init(PoseEvaluator::default, |evaluator, samples| {
            let mut ranges = still.clone();
            for sample in samples {
                let now = locals(&view, joints, evaluator, sample);
                for ((range, from), to) in ranges.iter_mut().zip(&start).zip(now) {
                    // A matrix has no rotation that a clip could change.
                    if let (NodeLocal::Trs { rotation: from, .. }, NodeLocal::Trs { rotation: to, .. }) = (from, to) {
                        grow(range, vector_of(between(*from, to)).map(|x| [x, x]));
                    }
                }
            }
            ranges
        })
        .reduce(
            || still.clone(),
            |mut all, some| {
                all.iter_mut().zip(some).for_each(|(range, other)| grow(range, other));
                all
            },
        )
}

fn grow(range: &mut Range, other: Range) {
    for (own, other) in range.iter_mut().zip(other) {
        *own = [own[0].min(other[0]), own[1].max(other[1])];
    }
}

/// The local map of each joint.
fn locals(view: &ModelView, joints: &[Joint], evaluator: &mut PoseEvaluator, sample: &SampleRow) -> Vec<NodeLocal> {
    let clip = (sample.clip != NONE).then_some(sample.clip as usize);
    let mut out = Vec::with_capacity(joints.len());
    // Nodes come in ascending order, as the joints do.
    evaluator.evaluate_with(view, clip, sample.seconds, &mut Pose::default(), |node, local| {
        if joints.get(out.len()).is_some_and(|joint| joint.node == node) {
            out.push(*local);
        }
    });
    out
}
