use super::values;
use clap::{Args, ValueEnum};
use std::{path::PathBuf, str::FromStr};

/// Options that say which poses the boxes of bones and morph weights are made for.
#[derive(Debug, Args)]
#[command(next_help_heading = "Poses")]
pub struct PoseArgs {
    /// Clip to keep in the file; give it again for more clips [default: all clips]
    #[arg(long = "clip", value_name = "NAME")]
    pub clips: Vec<String>,
    /// Poses that the boxes of bones and morph weights are made for, beside the one without any clip. clips: those of all
    /// clips in the file. clip=NAME: those of one; the others stay in the file. limits: all clips, and random rotations of
    /// all joints within joint limits. arbitrary: all clips, and any rotations of all joints
    #[arg(long, value_name = "arbitrary|limits|clips|clip=NAME", default_value = "clips")]
    pub pose_space: PoseSpaceKind,
    /// For --pose-space limits: how far joints turn from where they are without any clip, as rotation vectors in degrees,
    /// -180 to 180, in a TOML file: [joints."NAME"] with x, y, z = [LEAST, GREATEST], an axis that is not there keeps still
    /// [default: every joint as far as the clips turn it]
    #[arg(long, value_name = "FILE")]
    pub joint_limits: Option<PathBuf>,
    /// For --pose-space limits: joints that FILE does not name turn as far as the clips turn them about each axis, and this
    /// much more to both sides; degrees, 0 to 180 [default: 10]
    #[arg(long, value_name = "DEGREES", value_parser = |text: &str| values::degrees(text, 0.0, 180.0))]
    pub limit_slack: Option<f64>,
    /// For --pose-space arbitrary and limits: random poses, 1 to 100000 [default: 1000 for arbitrary, 245 for limits]
    #[arg(long, value_name = "N", value_parser = |text: &str| values::count(text, 100_000))]
    pub pose_samples: Option<usize>,
    /// For --pose-space arbitrary and limits: seed of the random poses, any whole number from 0 [default: 1]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Time between sampled poses of clips, seconds; above 0, at most 10 [default: 1/60]
    #[arg(long, value_name = "SECONDS", value_parser = |text: &str| values::number_in(text, 0.0, 10.0))]
    pub sample_step: Option<f64>,
    /// How the boxes of bones and morph weights are bounded; those of vertex caches hold at any time between keys
    #[arg(long, value_enum, default_value_t = BoundsKind::Envelope)]
    pub bounds: BoundsKind,
    /// Most envelopes of a cluster, 1 to 1024 [default: 64]
    #[arg(long, value_name = "N", value_parser = |text: &str| values::count(text, 1024))]
    pub envelopes: Option<usize>,
}

/// How the boxes are bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoundsKind {
    /// Around the sampled poses only: smaller boxes, but poses between the samples can miss hits
    Sampled,
    /// Around everything between the samples too, and widened for poses outside: no pose misses a hit
    Envelope,
}

/// A pose space, without what other options say about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PoseSpaceKind {
    Arbitrary,
    Limits,
    Clips,
    Clip(String),
}

impl FromStr for PoseSpaceKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.strip_prefix("clip=")) {
            ("arbitrary", _) => Ok(Self::Arbitrary),
            ("limits", _) => Ok(Self::Limits),
            ("clips", _) => Ok(Self::Clips),
            (_, Some("")) => Err("the clip's name is empty".to_owned()),
            (_, Some(name)) => Ok(Self::Clip(name.to_owned())),
            _ => Err("expected arbitrary, limits, clips or clip=NAME".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_space_is_one_of_four_words() {
        assert_eq!("clips".parse(), Ok(PoseSpaceKind::Clips));
        assert_eq!("clip=a=clips".parse(), Ok(PoseSpaceKind::Clip("a=clips".to_owned())));
        for wrong in ["", "clip", "clip=", "Clips", "random", "limits=3"] {
            assert!(wrong.parse::<PoseSpaceKind>().is_err(), "{wrong:?}");
        }
    }
}
