use super::values::{self, ClassOverride};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// glTF 2.0 file (.gltf or .glb)
    pub input: PathBuf,
    /// File to write; its name ends in .rpose and its folder exists
    #[arg(short, long, value_name = "OUT.rpose")]
    pub output: PathBuf,
    /// Do nothing when OUT was already made from the same source with the same options [default: off]
    #[arg(long)]
    pub if_changed: bool,

    /// Clip whose poses the boxes are made for; give it again for more clips [default: all clips]
    #[arg(long = "clip", value_name = "NAME", help_heading = "Poses")]
    pub clips: Vec<String>,
    /// Time between sampled poses, seconds; above 0, at most 10 [default: 1/60]
    #[arg(long, value_name = "SECONDS", value_parser = |text: &str| values::number_in(text, 0.0, 10.0), help_heading = "Poses")]
    pub sample_step: Option<f64>,
    /// How the boxes are bounded
    #[arg(long, value_enum, default_value_t = BoundsKind::Sampled, help_heading = "Poses")]
    pub bounds: BoundsKind,

    /// Motion class of a part, against the baker's own choice: static freezes it, rigid keeps a bone for a part that
    /// no clip moves; may be given again [default: the baker decides]
    #[arg(long = "class", value_name = "PART=CLASS", help_heading = "Motion classes")]
    pub classes: Vec<ClassOverride>,
}

/// How the boxes are bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoundsKind {
    /// Around the sampled poses only: smaller boxes, but poses between the samples can miss hits
    Sampled,
}
