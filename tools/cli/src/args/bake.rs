use super::{
    keyframed::{KeptFramesArgs, KeyframedArgs},
    poses::PoseArgs,
    tree::TreeArgs,
    values::ClassOverride,
};
use clap::Args;
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
    /// Do nothing when OUT was already made by this version from the same source with the same options [default: off]
    #[arg(long)]
    pub if_changed: bool,

    #[command(flatten)]
    pub frames: KeptFramesArgs,

    #[command(flatten)]
    pub poses: PoseArgs,

    #[command(flatten)]
    pub keyframed: KeyframedArgs,

    #[command(flatten)]
    pub tree: TreeArgs,

    /// Motion class of a part, against the baker's own choice: static freezes it, rigid keeps a bone for a part that
    /// no clip moves, keyframed or free takes a vertex cache through fuzzy trees or through a tree built in every frame,
    /// and makes one of morph targets without a skin whose weights every clip interpolates linearly; may be given again
    /// [default: the baker decides]
    #[arg(long = "class", value_name = "PART=CLASS", help_heading = "Motion classes")]
    pub classes: Vec<ClassOverride>,
}
