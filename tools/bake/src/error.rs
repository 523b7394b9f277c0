use crate::JointLimitsError;
use restpose_formats::{FormatError, rows::MotionClass};

/// Why an animation was not baked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The sample step is not a positive number.
    #[error("the sample step is {found} s; expected a finite number above zero")]
    SampleStep {
        /// Step given.
        found: f64,
    },
    /// A setting is out of its range.
    #[error("{name}: {found} given; expected a number from {least} to {most}")]
    Setting {
        /// Setting.
        name: &'static str,
        /// Number given.
        found: f64,
        /// Least number allowed.
        least: f64,
        /// Greatest number allowed.
        most: f64,
    },
    /// A clip that was asked for does not exist.
    #[error("no clip is called {name:?}; the source has: {known}", known = .known.join(", "))]
    UnknownClip {
        /// Name asked for.
        name: String,
        /// Names there are, or numbers where there is no name.
        known: Vec<String>,
    },
    /// The clip that the pose space is to be made of is not in the file.
    #[error("the pose space has no clip {name:?}; the file has: {known}", known = if .known.is_empty() { "none".to_owned() } else { .known.join(", ") })]
    PoseSpaceClip {
        /// Name asked for.
        name: String,
        /// Names of the clips of the file, or numbers where there is no name.
        known: Vec<String>,
    },
    /// Joint limits that do not fit.
    #[error(transparent)]
    JointLimits(#[from] JointLimitsError),
    /// A class was given for a part that does not exist.
    #[error("no part is called {name:?}; the source has: {known}", known = .known.join(", "))]
    UnknownPart {
        /// Name asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// A part cannot have the class that was asked for.
    #[error("part {name:?} cannot be {}: it is {} ({reason}); a part can be made static, a static one rigid, and one with a vertex cache keyframed or free", .asked.name(), .found.name())]
    Class {
        /// Part.
        name: String,
        /// Class asked for.
        asked: MotionClass,
        /// Class found.
        found: MotionClass,
        /// Why that was found.
        reason: String,
    },
    /// The clips give more samples than a bake takes.
    #[error("clip {clip:?} gives {found} samples, more than {limit}: take a longer sample step")]
    TooManySamples {
        /// Clip.
        clip: String,
        /// Samples.
        found: u64,
        /// Most that are taken.
        limit: u64,
    },
    /// A count does not fit the file's 32-bit indices.
    #[error("{what}: {found} do not fit the file's 32-bit indices; split the scene into several files")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many.
        found: u64,
    },
    /// A pose overflows the range of `f32`.
    #[error("bone {bone:?} leaves the range of f32 {pose}: scale the scene down")]
    PoseOverflow {
        /// Bone.
        bone: String,
        /// Which pose: in a clip at a time, without any clip, or a random one.
        pose: String,
    },
    /// No triangle has an area.
    #[error("no triangle has an area in any pose: there is nothing to trace")]
    NothingToTrace,
    /// The finished model breaks a rule of the format; a defect of the bake, not of the source.
    #[error("the bake made a file that breaks the format's rules; please report this: {0}")]
    Format(#[from] FormatError),
}
