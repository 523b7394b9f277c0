//! The bake: import, classify, assemble, sample, decompose, build. Each stage is a library function with its settings;
//! none prints, exits or keeps state between calls. [`bake`] lists them in order.

mod assemble;
mod bounds;
mod caches;
mod clip_bounds;
mod cost;
mod error;
mod fuzzy_tree;
pub mod import;
mod motion;
mod pipeline;
mod posed_nodes;
mod poses;
mod progress;
mod report;
mod settings;
pub mod subdivide;
mod trees;
pub mod verify;
mod write_file;

pub use caches::{CacheReport, ExpectedFrame, SegmentReport};
pub use error::BakeError;
pub use motion::keyframed::{DecomposeReport, DecomposeSettings};
pub use pipeline::{Baked, bake};
pub use poses::{JointLimits, JointLimitsError, JointRange, LimitSettings, PoseSpace};
pub use progress::{NoProgress, Progress};
pub use report::{BakeReport, PartReport, StageSeconds};
pub use restpose_formats::rows::MotionClass;
pub use settings::{BakeSettings, ClipSelection};
pub use write_file::write_file;
