use crate::{Affine, Pose, PoseError, PoseEvaluator};
use restpose_formats::{
    ModelView,
    rows::{ClipBoundsRow, ClipRow},
};
use std::sync::Arc;

/// Where an instance stands and how: its transform and its pose. A small value: a clip and a time, or a shared palette.
///
/// Keep states and give them back to [`Scene::set_state`](crate::Scene::set_state), to this or any other instance of the
/// asset: a server that rewinds its players does so, and copies nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceState {
    /// World space from asset space.
    pub(crate) transform: Affine,
    pub(crate) pose: PoseSource,
}

/// Where a pose comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PoseSource {
    /// The source without any clip.
    Default,
    Clip {
        clip: u32,
        seconds: f32,
    },
    Given(Arc<Pose>),
}

impl InstanceState {
    /// At the origin, in the pose without any clip.
    pub(crate) const NEW: Self = Self {
        transform: Affine::IDENTITY,
        pose: PoseSource::Default,
    };

    /// World space from asset space.
    #[must_use]
    pub fn transform(&self) -> &Affine {
        &self.transform
    }

    /// Refuses a pose of another asset.
    pub(crate) fn check(&self, model: &ModelView) -> Result<(), PoseError> {
        match &self.pose {
            PoseSource::Default => Ok(()),
            PoseSource::Clip { clip, seconds } => check_clip(model, *clip as usize, *seconds),
            PoseSource::Given(pose) => {
                check_palette(model, &pose.palette, &pose.morph_weights)?;
                check_cache_frames(model, &pose.cache_frames)
            }
        }
    }
}

impl PoseSource {
    /// The row of clip bounds that holds for it, if the file has any; `None` for a pose of the caller's.
    pub(crate) fn clip_bounds_row(&self, clips: &[ClipRow]) -> Option<usize> {
        match *self {
            Self::Default => Some(ClipBoundsRow::row_at(clips, None, 0.0)),
            Self::Clip { clip, seconds } => Some(ClipBoundsRow::row_at(clips, Some(clip as usize), seconds)),
            Self::Given(_) => None,
        }
    }

    /// Writes the pose.
    pub(crate) fn evaluate(&self, model: &ModelView, evaluator: &mut PoseEvaluator, out: &mut Pose) {
        match self {
            Self::Default => evaluator.evaluate(model, None, 0.0, out),
            Self::Clip { clip, seconds } => evaluator.evaluate(model, Some(*clip as usize), *seconds, out),
            Self::Given(pose) => out.clone_from(pose),
        }
    }
}

pub(crate) fn check_clip(model: &ModelView, clip: usize, seconds: f32) -> Result<(), PoseError> {
    let count = model.clips.len();
    if clip >= count {
        return Err(PoseError::UnknownClip { clip, count });
    }
    if !seconds.is_finite() {
        return Err(PoseError::TimeNotFinite { seconds });
    }
    Ok(())
}

pub(crate) fn check_palette(model: &ModelView, palette: &[Affine], morph_weights: &[f32]) -> Result<(), PoseError> {
    let (expected, found) = (model.bones.len(), palette.len());
    if expected != found {
        return Err(PoseError::PaletteLength { expected, found });
    }
    let (expected, found) = (model.morph_targets.len(), morph_weights.len());
    if expected != found {
        return Err(PoseError::MorphWeightsLength { expected, found });
    }
    if let Some(bone) = palette.iter().position(|x| !x.is_finite()) {
        let name = model.meta.bone_names.get(bone).cloned().unwrap_or_default();
        return Err(PoseError::BoneNotFinite { bone, name });
    }
    if let Some(target) = morph_weights.iter().position(|weight| !weight.is_finite()) {
        return Err(PoseError::MorphWeightNotFinite { target });
    }
    Ok(())
}

pub(crate) fn check_cache_frames(model: &ModelView, frames: &[f64]) -> Result<(), PoseError> {
    let (expected, found) = (model.caches.len(), frames.len());
    if expected != found {
        return Err(PoseError::CacheFramesLength { expected, found });
    }
    if let Some(cache) = frames.iter().position(|frame| !frame.is_finite()) {
        return Err(PoseError::CacheFrameNotFinite { cache });
    }
    Ok(())
}
