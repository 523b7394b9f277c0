use clap::Args;
use std::path::PathBuf;

/// Options of `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder for the baked files and the pictures; made if missing
    #[arg(short, long, value_name = "FOLDER", default_value = "out/demo")]
    pub output: PathBuf,
    /// Folder with the sample scenes: .gltf, .glb, .obj, and .obj with the .pc2 or .mdd of the same name
    #[arg(long, value_name = "FOLDER", default_value = "samples/scenes")]
    pub scenes: PathBuf,
}
