use super::{
    BuildersArgs, FrameArgs,
    keyframed::{KeptFramesArgs, KeyframedArgs},
    tree::TreeArgs,
    values::{self, ClassOverride},
};
use crate::exit_code::ExitCode;
use clap::{Args, Subcommand};
use std::{num::NonZeroUsize, path::PathBuf};

/// Options of `measure`.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    #[command(subcommand)]
    pub table: MeasureTable,
}

/// What to measure.
#[derive(Debug, Subcommand)]
pub enum MeasureTable {
    /// Whole frames against their number of rays, every strategy
    #[command(after_help = ExitCode::table())]
    Frame(FrameArgs),
    /// Frame updates and rays against the number of triangles, beside a static tree built anew for each frame
    #[command(after_help = ExitCode::table())]
    Tessellations(TessellationsArgs),
    /// A keyframed animation's clusters, and its rays beside a tree rebuilt for every frame
    #[command(after_help = ExitCode::table())]
    Motion(MotionArgs),
    /// Pose spaces, ways to bound their boxes, preprocessing, and what sampling loses
    #[command(after_help = ExitCode::table())]
    Poses(PosesArgs),
    /// Every tree builder: how fast it builds, how good its trees are, and what threads gain
    #[command(after_help = ExitCode::table())]
    Builders(BuildersArgs),
}

/// Options of `measure tessellations`.
#[derive(Debug, Args)]
pub struct TessellationsArgs {
    /// glTF 2.0 file (.gltf or .glb)
    pub source: PathBuf,
    /// Folder for tessellations.html (table and plots) and tessellations.json; made if missing [default: no files]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Measure the mesh subdivided 0 to MAX times, MAX from 0 to 5; each time has four times the triangles
    #[arg(long, value_name = "MAX", default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=5))]
    pub subdivide: u32,
    /// Posed frames whose rays are traced, 1 to 1000, spread evenly over the sampled poses
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub frames: u16,
    /// Thread counts to measure, such as 1,2,8; each 1 to 1024 [default: 1 and what --threads says]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::threads)]
    pub thread_counts: Vec<NonZeroUsize>,

    #[command(flatten)]
    pub tree: TreeArgs,
}

/// Options of `measure motion`.
///
/// Motion is free only where that is asked for: there are no clusters to measure in it.
#[derive(Debug, Args)]
#[command(mut_arg("rays_per_frame", |arg| arg.default_value("0")))]
pub struct MotionArgs {
    /// One scene: an OBJ mesh and the vertex cache that moves it (.pc2 or .mdd), OBJ files as frames in this order, a
    /// folder of them, or a glTF 2.0 file (.gltf, .glb)
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Folder for motion.html (tables and plots) and motion.json; made if missing [default: no files]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Times of the first clip whose rays are traced, 1 to 100000, spread evenly over its keys; every other one lies
    /// between two keys
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = |text: &str| values::count(text, 100_000))]
    pub poses: usize,
    /// Width and height of the picture whose camera rays are traced, pixels, 1 to 8192
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub picture_side: u32,
    /// Random rays per pose, 1 or more
    #[arg(long, value_name = "N", default_value_t = 65_536, value_parser = clap::value_parser!(u32).range(1..))]
    pub random_rays: u32,
    /// Times that each set of rays is timed, 1 or more; the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeats: u32,
    /// Thread counts of pictures, such as 1,2,8; each 1 to 1024; times per ray are those of the first [default: 1 and
    /// what --threads says]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::threads)]
    pub thread_counts: Vec<NonZeroUsize>,

    #[command(flatten)]
    pub frames: KeptFramesArgs,
    #[command(flatten)]
    pub keyframed: KeyframedArgs,
    #[command(flatten)]
    pub tree: TreeArgs,

    /// Motion class of a part, against the baker's own choice, as `bake` takes it; may be given again [default: the
    /// baker decides]
    #[arg(long = "class", value_name = "PART=CLASS", help_heading = "Motion classes")]
    pub classes: Vec<ClassOverride>,
}

/// Options of `measure poses`.
#[derive(Debug, Args)]
pub struct PosesArgs {
    /// glTF 2.0 files (.gltf or .glb) with clips, a scene each
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Folder for poses.html (tables and plots) and poses.json; made if missing [default: no files]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Clip of the pose space that holds only one: its name, or its number in the source [default: the first]
    #[arg(long, value_name = "NAME")]
    pub clip: Option<String>,
    /// Rays of each kind, camera and random, per pose, fewer where they cost too much; 1 to 16777216
    #[arg(long, value_name = "N", default_value_t = 4_096, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub rays: u32,
    /// Poses of each kind, 1 to 10000: clips between samples, blends of clips, ragdolls
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = |text: &str| values::count(text, 10_000))]
    pub poses: usize,
    /// Measure the mesh subdivided 0 to MAX times, MAX from 0 to 5; each time has four times the triangles
    #[arg(long, value_name = "MAX", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=5))]
    pub levels: u32,
    /// Times that each turn of rays is timed, 1 or more; the least counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeats: u32,
    /// Seed of random poses and rays, any whole number from 0
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    #[command(flatten)]
    pub tree: TreeArgs,
}
