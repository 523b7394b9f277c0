use crate::{BakeError, Progress};
use rayon::prelude::*;
use restpose_formats::{
    Model,
    geom::Affine,
    rows::{NONE, SampleRow},
};
use restpose_runtime::{Pose, PoseEvaluator, invert_frame};

/// A pose of the pose space, with the very numbers that the runtime poses with.
pub(crate) struct SampledPose {
    /// Asset space from rest space, per bone row.
    pub palette: Vec<Affine>,
    /// Per morph target row.
    pub morph_weights: Vec<f32>,
    /// Rest space from asset space, rows of the linear part, per bone row; `None` where the runtime, too, will find no
    /// usable inverse and refit that cluster's tree.
    pub inverses: Vec<Option<[[f64; 3]; 3]>>,
}

impl SampledPose {
    /// A pose of `model`; `which` says in messages which one it is.
    ///
    /// # Errors
    /// [`BakeError::PoseOverflow`].
    pub(crate) fn new(model: &Model, pose: Pose, which: impl FnOnce() -> String) -> Result<Self, BakeError> {
        let Pose {
            palette,
            morph_weights,
            cache_frames: _,
        } = pose;
        if let Some(bone) = palette.iter().position(|x| !x.is_finite()) {
            let bone = model.meta.bone_names[bone].clone();
            return Err(BakeError::PoseOverflow { bone, pose: which() });
        }
        let inverses = palette.iter().map(invert_frame).collect();
        Ok(Self {
            palette,
            morph_weights,
            inverses,
        })
    }
}

/// Evaluates the samples on all cores; order and bits do not depend on how many there are.
pub(crate) fn evaluate(
    model: &Model,
    samples: &[SampleRow],
    progress: &dyn Progress,
) -> Result<Vec<SampledPose>, BakeError> {
    let view = model.view();
    samples
        .par_iter()
        .map_init(PoseEvaluator::default, |evaluator, sample| {
            let clip = (sample.clip != NONE).then_some(sample.clip as usize);
            let mut pose = Pose::default();
            evaluator.evaluate(&view, clip, sample.seconds, &mut pose);
            let sampled = SampledPose::new(model, pose, || match clip {
                Some(clip) => format!("in clip {:?} at {} s", model.meta.clip_names[clip], sample.seconds),
                None => "without any clip".to_owned(),
            })?;
            progress.advance(1);
            Ok(sampled)
        })
        .collect()
}
