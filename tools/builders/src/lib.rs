//! The tree builders of the papers that no frame needs: for the baker, and to compare with those of the runtime
//! (`restpose_runtime::build`).
//!
//! All take [`CheckedBoxes`](restpose_runtime::build::CheckedBoxes) and give the runtime's tree types, so each tree is
//! judged by the same `validate()` and the same cost.
#![forbid(unsafe_code)]

pub mod bvh;
pub mod kd;
