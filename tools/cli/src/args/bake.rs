use super::{
    keyframed::{KeptFramesArgs, KeyframedArgs},
    values::{self, ClassOverride},
};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// One scene: a glTF 2.0 file (.gltf, .glb), an OBJ mesh (.obj), an OBJ mesh and the vertex cache that moves it
    /// (.pc2 or .mdd), OBJ files as frames in this order, or a folder of them
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// File to write; its name ends in .rpose and its folder exists
    #[arg(short, long, value_name = "OUT.rpose")]
    pub output: PathBuf,
    /// Do nothing when OUT was already made from the same source with the same options [default: off]
    #[arg(long)]
    pub if_changed: bool,

    #[command(flatten)]
    pub frames: KeptFramesArgs,

    /// Clip whose poses the boxes are made for; give it again for more clips [default: all clips]
    #[arg(long = "clip", value_name = "NAME", help_heading = "Poses")]
    pub clips: Vec<String>,
    /// Time between sampled poses of bones and morph weights, seconds; above 0, at most 10 [default: 1/60]
    #[arg(long, value_name = "SECONDS", value_parser = |text: &str| values::number_in(text, 0.0, 10.0), help_heading = "Poses")]
    pub sample_step: Option<f64>,
    /// How the boxes of bones and morph weights are bounded; those of vertex caches hold at any time between keys
    #[arg(long, value_enum, default_value_t = BoundsKind::Sampled, help_heading = "Poses")]
    pub bounds: BoundsKind,

    #[command(flatten)]
    pub keyframed: KeyframedArgs,

    /// Motion class of a part, against the baker's own choice: static freezes it, rigid keeps a bone for a part that
    /// no clip moves, keyframed or free takes a vertex cache through fuzzy trees or through a tree built in every frame,
    /// and makes one of morph targets without a skin whose weights every clip interpolates linearly; may be given again
    /// [default: the baker decides]
    #[arg(long = "class", value_name = "PART=CLASS", help_heading = "Motion classes")]
    pub classes: Vec<ClassOverride>,
}

/// How the boxes are bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoundsKind {
    /// Around the sampled poses only: smaller boxes, but poses between the samples can miss hits
    Sampled,
}
