use super::values;
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
    /// Frame updates and rays against the number of triangles, beside a static tree built anew for each frame
    Frame(FrameArgs),
}

/// Options of `measure frame`.
#[derive(Debug, Args)]
pub struct FrameArgs {
    /// glTF 2.0 file (.gltf or .glb)
    pub source: PathBuf,
    /// Folder for frame.html (table and plots) and frame.json; made if missing [default: no files]
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
}
