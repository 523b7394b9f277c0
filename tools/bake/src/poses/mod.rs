//! The pose space: which poses the fuzzy boxes are made for, and those poses evaluated.

mod joint_limits;
mod joint_ranges;
mod pose;
mod pose_space;
mod random_poses;
mod relative_motion;
mod rotation;
mod sample_times;
mod span;
mod span_map;
#[cfg(test)]
mod tests;
mod world_span;

pub use joint_limits::{JointLimits, JointLimitsError, JointRange};
pub(crate) use pose::{SampledPose, evaluate};
pub use pose_space::{LimitSettings, PoseSpace};
pub(crate) use random_poses::random_poses;
pub(crate) use relative_motion::{BoneSpans, Chord, Way, about, in_palette};
pub(crate) use sample_times::sample_rows;
#[cfg(test)]
use span::spans_with_times;
pub(crate) use span::{Span, spans};
pub(crate) use world_span::{WorldSpan, number_error};
