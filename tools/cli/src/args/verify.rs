use clap::Args;
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
    /// Poses to trace them in, 1 to 1000000: bones and morph weights at the file's samples, spread evenly, vertex caches
    /// at random times, every fourth time at a key; without vertex caches no more than there are samples
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub poses: u64,
    /// Seed of the random rays, any whole number from 0
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
