//! The pose space: which poses the fuzzy boxes are made for, and those poses evaluated.

mod joint_limits;
mod joint_ranges;
mod pose;
mod pose_space;
mod random_poses;
mod rotation;
mod sample_times;
#[cfg(test)]
mod tests;

pub use joint_limits::{JointLimits, JointLimitsError, JointRange};
pub(crate) use pose::{SampledPose, evaluate};
pub use pose_space::{LimitSettings, PoseSpace};
pub(crate) use random_poses::random_poses;
pub(crate) use sample_times::sample_rows;
