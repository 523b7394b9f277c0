use super::{frame_range::frame_range, values};
use clap::{ArgAction, Args};
use restpose_bake::{
    BakeSettings, DecomposeSettings,
    import::{FrameRange, ImportSettings},
};

/// Options that say which frames are read, and when they are.
#[derive(Debug, Args)]
#[command(next_help_heading = "Frames of vertex caches and OBJ sequences")]
pub struct KeptFramesArgs {
    /// Frames per second, above 0, at most 1000000 [default: 24; of an .mdd file, its own times]
    #[arg(long, value_name = "FPS", value_parser = |text: &str| values::number_in(text, 0.0, 1e6))]
    pub frame_rate: Option<f64>,
    /// Frames to keep, counted from 0: all from FIRST to LAST, or every STEP-th of these; without LAST to the end
    /// [default: all]
    #[arg(long, value_name = "FIRST-[LAST][/STEP]", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
}

impl KeptFramesArgs {
    /// What the import takes.
    pub fn settings(&self) -> ImportSettings {
        ImportSettings {
            frame_rate: self.frame_rate,
            frames: self.frames.unwrap_or_default(),
        }
    }
}

/// Options that say how vertex caches are baked.
#[derive(Debug, Args)]
#[command(next_help_heading = "Vertex caches")]
pub struct KeyframedArgs {
    /// Greatest distance of a stored position from the source's at a key, scene units, 0 or more; 0 stores positions as
    /// they are [default: 2^-16 of the part's greatest diagonal]
    #[arg(long, value_name = "UNITS", value_parser = |text: &str| values::number_from(text, 0.0, f64::MAX))]
    pub position_error: Option<f64>,
    /// Most clusters of a part and segment, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = motion().max_clusters, value_parser = |text: &str| values::count(text, 65_536))]
    pub max_clusters: usize,
    /// No cluster is added once each lowers the residual by less than this fraction of it, 0 to 1
    #[arg(long, value_name = "FRACTION", default_value_t = motion().cluster_threshold, value_parser = |text: &str| values::number_from(text, 0.0, 1.0))]
    pub cluster_threshold: f64,
    /// Relaxation ends once an iteration lowers the residual by less than this fraction of it, 0 to 1
    #[arg(long, value_name = "FRACTION", default_value_t = motion().iteration_threshold, value_parser = |text: &str| values::number_from(text, 0.0, 1.0))]
    pub iteration_threshold: f64,
    /// Most iterations for one number of clusters, 1 to 1000000
    #[arg(long, value_name = "N", default_value_t = motion().max_iterations, value_parser = |text: &str| values::count(text, 1_000_000))]
    pub max_iterations: usize,
    /// Try every N-th key as rest pose, 1 to 1000000
    #[arg(long, value_name = "N", default_value_t = motion().rest_step, value_parser = |text: &str| values::count(text, 1_000_000))]
    pub rest_step: usize,
    /// Turn clusters to the principal axes of their motion where that lowers the expected cost: on or off
    #[arg(long, value_name = "ON|OFF", default_value = on_or_off(motion().principal_axes), value_parser = values::switch, action = ArgAction::Set)]
    pub principal_axes: bool,
    /// Most time segments of a part, each with its own clusters and trees, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().segments, value_parser = |text: &str| values::count(text, 65_536))]
    pub segments: usize,
    /// Keep more time segments, and boxes at more keys, where the saved fraction of the expected cost is at least this times
    /// the added fraction of bytes, 0 or more
    #[arg(long, value_name = "FACTOR", default_value_t = BakeSettings::default().size_worth, value_parser = |text: &str| values::number_from(text, 0.0, f64::MAX))]
    pub size_worth: f64,
    /// Rays of a frame that meet the part, 0 or more: where posing all of it and building a tree in every frame is expected
    /// to take less time than fuzzy trees, on one thread, motion is free; 0: only where --class says so
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().rays_per_frame, value_parser = |text: &str| values::number_from(text, 0.0, f64::MAX))]
    pub rays_per_frame: f64,
}

impl KeyframedArgs {
    /// Bake settings with these options, else the defaults.
    pub fn settings(&self) -> BakeSettings {
        BakeSettings {
            position_error: self.position_error,
            motion: DecomposeSettings {
                max_clusters: self.max_clusters,
                iteration_threshold: self.iteration_threshold,
                cluster_threshold: self.cluster_threshold,
                max_iterations: self.max_iterations,
                rest_step: self.rest_step,
                principal_axes: self.principal_axes,
                ..DecomposeSettings::default()
            },
            segments: self.segments,
            size_worth: self.size_worth,
            rays_per_frame: self.rays_per_frame,
            ..BakeSettings::default()
        }
    }
}

fn motion() -> DecomposeSettings {
    DecomposeSettings::default()
}

fn on_or_off(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}
