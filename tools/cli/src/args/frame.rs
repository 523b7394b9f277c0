use super::{
    keyframed::{KeptFramesArgs, KeyframedArgs},
    values::{self, ClassOverride},
};
use clap::{Args, ValueEnum};
use restpose_measure::frame::{FrameSettings, Palettes, RayKind, strategy_names};
use std::{num::NonZeroUsize, path::PathBuf};

/// Options of `measure frame`.
#[derive(Debug, Args)]
pub struct FrameArgs {
    /// Scenes: baked files (.rpose), glTF 2.0 files (.gltf, .glb), OBJ meshes, folders of OBJ files as frames, or an OBJ
    /// mesh and the vertex cache that moves it joined by a plus sign (mesh.obj+cache.pc2)
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Folder for frame.html (plots and tables) and frame.json; made if missing [default: no files]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Folder for the baked files, each to be given as SCENE another time: NAME-4^N-TREE.rpose, subdivided N times; made if
    /// missing [default: no files]
    #[arg(long, value_name = "FOLDER")]
    pub keep: Option<PathBuf>,
    /// Subdivide the meshes so many times before they are baked, 0 to 5; each time has four times the triangles
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=5))]
    pub subdivide: u32,
    /// Instances on a grid, each at its own phase of the first clip, 1 to 1048576
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = |text: &str| values::count(text, 1 << 20))]
    pub instances: usize,
    /// Strategy to measure; may be given again; at least one of restpose, whose hits are the others' measure. Where some have
    /// kd-trees and some wide ones, vertex caches are stored exactly, whatever --position-error says [default: all]
    #[arg(long = "strategy", value_name = "NAME", value_parser = clap::builder::PossibleValuesParser::new(strategy_names()))]
    pub strategies: Vec<String>,
    /// Rays of a frame, each 1 to 16777216; pictures have about as many [default: 1, 10, 100 and so on to 1000000]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub rays: Vec<u32>,
    /// Kinds of rays: random and segment run through the scene's box, a segment ends there; primary is a picture of the
    /// whole scene, close-up of its middle, three times as large [default: random,primary,close-up]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub ray_kinds: Vec<RayKind>,
    /// Poses that frames go through, 1 to 10000, spread evenly over the first clip
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = |text: &str| values::count(text, 10_000))]
    pub poses: usize,
    /// Who makes palettes: the frame evaluates clips, or they are given to it
    #[arg(long, value_name = "HOW", value_enum, default_value_t = PaletteSource::Evaluated)]
    pub palettes: PaletteSource,
    /// Seconds of a strategy's frames with one number of rays, after which it has no further turn, 0 to 1000000; a turn is
    /// a frame of every pose
    #[arg(long, value_name = "SECONDS", default_value_t = 0.25, value_parser = |text: &str| values::number_from(text, 0.0, 1e6))]
    pub seconds: f64,
    /// Most turns of a strategy with one number of rays, 1 or more
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub turns: u32,
    /// Thread counts to measure, such as 1,2,8; each 1 to 1024 [default: 1 and what --threads says]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::threads)]
    pub thread_counts: Vec<NonZeroUsize>,
    /// Seed of random rays, any whole number from 0
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    #[command(flatten)]
    pub frames: KeptFramesArgs,
    #[command(flatten)]
    pub keyframed: KeyframedArgs,

    /// Motion class of a part, against the baker's own choice, as `bake` takes it; may be given again [default: the
    /// baker decides]
    #[arg(long = "class", value_name = "PART=CLASS", help_heading = "Motion classes")]
    pub classes: Vec<ClassOverride>,
}

/// Who makes palettes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PaletteSource {
    /// Clips are evaluated within the frame
    Evaluated,
    /// They are there before the frame begins
    Given,
}

impl FrameArgs {
    /// What the measurement takes.
    pub fn settings(&self) -> FrameSettings {
        let mut settings = FrameSettings {
            poses: self.poses,
            palettes: match self.palettes {
                PaletteSource::Evaluated => Palettes::Evaluated,
                PaletteSource::Given => Palettes::Given,
            },
            seconds: self.seconds,
            turns: self.turns,
            seed: self.seed,
            ..FrameSettings::default()
        };
        if !self.strategies.is_empty() {
            settings.strategies.clone_from(&self.strategies);
        }
        if !self.rays.is_empty() {
            settings.rays.clone_from(&self.rays);
            settings.rays.sort_unstable();
            settings.rays.dedup();
        }
        if !self.ray_kinds.is_empty() {
            settings.ray_kinds.clone_from(&self.ray_kinds);
        }
        if !self.thread_counts.is_empty() {
            settings.threads = self.thread_counts.iter().copied().map(NonZeroUsize::get).collect();
        }
        settings
    }
}
