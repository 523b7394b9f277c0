//! The pose space: which poses the fuzzy boxes are made for, and those poses evaluated.

mod pose;
mod sample_times;

pub(crate) use pose::{SampledPose, evaluate};
pub(crate) use sample_times::sample_rows;
