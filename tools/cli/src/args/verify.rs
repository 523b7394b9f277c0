use clap::{Args, ValueEnum};
use restpose_bake::verify::PoseSource;
use std::path::PathBuf;

/// Options of `verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// A .rpose file
    pub file: PathBuf,
    /// What it was baked from, as `bake` was given it; frame rate and range are in the file
    #[arg(required = true, value_name = "SOURCE")]
    pub sources: Vec<PathBuf>,
    /// Rays in all, 1 to 1000000000
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub rays: u64,
    /// Poses to trace them in, 1 to 1000000, every second one under a random transform; no more than there are rays, nor,
    /// of samples without vertex caches, than there are
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub poses: u64,
    /// Where bones and morph weights stand; vertex caches stand at random times, every fourth time at a key. With boxes
    /// that were bounded around samples, clips and random show what sampling loses: missed hits, and exit code 7
    /// [default: samples for such boxes, clips for boxes that hold in any pose]
    #[arg(long, value_enum, value_name = "SOURCE")]
    pub pose_source: Option<PoseSourceKind>,
    /// Seed of the random poses and rays, any whole number from 0; the same seed and number of poses give the same poses
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Where poses come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PoseSourceKind {
    /// The file's samples, spread evenly
    Samples,
    /// The file's clips at random times, every fourth time at a key
    Clips,
    /// Poses far outside any clip: ragdolls, small turns of every joint, blends and mixes of clips, bones scaled, sheared,
    /// mirrored, flattened or scaled to nothing, near-singular or far away, and morph weights from -2 to 3
    Random,
}

impl From<PoseSourceKind> for PoseSource {
    fn from(kind: PoseSourceKind) -> Self {
        match kind {
            PoseSourceKind::Samples => Self::Samples,
            PoseSourceKind::Clips => Self::Clips,
            PoseSourceKind::Random => Self::Random,
        }
    }
}
