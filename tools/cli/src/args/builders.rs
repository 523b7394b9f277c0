use super::{keyframed::KeptFramesArgs, values};
use clap::{ArgAction, Args};
use restpose_measure::builders::{Generated, builder_names};
use std::{num::NonZeroUsize, path::PathBuf};

/// Options of `measure builders`.
#[derive(Debug, Args)]
pub struct BuildersArgs {
    /// Scenes: glTF 2.0 files (.gltf, .glb), OBJ meshes, folders of OBJ files as frames, or an OBJ mesh and the vertex
    /// cache that moves it joined by a plus sign (mesh.obj+cache.pc2)
    #[arg(required_unless_present = "generated", value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// A scene that is made: regular=N is a scanned surface of N like triangles, uneven=N a furnished room of very uneven
    /// ones, N from 1 to 100000000; may be given again [default: none]
    #[arg(long, value_name = "KIND=N")]
    pub generated: Vec<Generated>,
    /// Folder for builders.html (tables and plots) and builders.json; made if missing [default: no files]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Builder to measure; may be given again, the first of each kind of tree is what the others are compared with;
    /// kd-tracked and kd-tracked-paper follow animations and say nothing of other scenes [default: all]
    #[arg(long = "builder", value_name = "NAME", value_parser = clap::builder::PossibleValuesParser::new(builder_names()))]
    pub builders: Vec<String>,
    /// Thread counts of the parallel builders, such as 1,2,8; each 1 to 1024 [default: 1, 2, 4 and so on up to what
    /// --threads says]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::threads)]
    pub thread_counts: Vec<NonZeroUsize>,
    /// Measure every scene with its triangles in random order, too: on or off
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_parser = values::switch, action = ArgAction::Set)]
    pub shuffled: bool,
    /// Times that each build is timed, 1 or more; the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeats: u32,
    /// Seconds after which a build is not repeated any more, 0 to 1000000
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = |text: &str| values::number_from(text, 0.0, 1e6))]
    pub seconds: f64,
    /// Width and height of the picture whose camera rays are traced, pixels, 1 to 8192; of scenes of more than a million
    /// triangles fewer rays
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub picture_side: u32,
    /// Random rays, 1 or more; of scenes of more than a million triangles fewer
    #[arg(long, value_name = "N", default_value_t = 65_536, value_parser = clap::value_parser!(u32).range(1..))]
    pub random_rays: u32,
    /// Most frames of an animation for which trees are built one after the other, 1 to 100000
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = |text: &str| values::count(text, 100_000))]
    pub animation_frames: usize,
    /// Seed of generated scenes, random order and random rays, any whole number from 0
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    #[command(flatten)]
    pub frames: KeptFramesArgs,
}
