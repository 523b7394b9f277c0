use super::values::{self, Size, Vector};
use crate::picture::CameraPlace;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A .rpose file
    pub file: PathBuf,
    /// Folder for frame_0000.png, frame_0001.png, ... and animation.gif; made if missing
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// What the pictures show
    #[arg(long, value_enum, default_value_t = View::Shaded)]
    pub view: View,

    /// Clip to play, by name or by number from 0 [default: the first clip; without clips, the pose of the file]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Time")]
    pub clip: Option<String>,
    /// Pictures, 1 to 9999, spread evenly over the time from --from up to, but without, --to
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=9999), help_heading = "Time")]
    pub frames: u32,
    /// First time, seconds, 0 or more [default: the clip's first key]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, help_heading = "Time")]
    pub from: Option<f32>,
    /// Last time, seconds, not before --from [default: the clip's last key]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, help_heading = "Time")]
    pub to: Option<f32>,

    /// Pixels, each side 16 to 8192
    #[arg(long, value_name = "WxH", default_value_t = Size { width: 512, height: 512 }, help_heading = "Picture")]
    pub size: Size,
    /// Rays per pixel
    #[arg(long, value_enum, default_value_t = SamplesPerPixel::Four, help_heading = "Picture")]
    pub samples: SamplesPerPixel,
    /// Direction towards the light, world space, any length above 0
    #[arg(long, value_name = "X,Y,Z", default_value_t = Vector::DEFAULT_LIGHT, value_parser = values::direction, allow_hyphen_values = true, help_heading = "Picture")]
    pub light: Vector,
    /// Leave out the floor under the model, and with it the shadow that it catches [default: a floor]
    #[arg(long, help_heading = "Picture")]
    pub no_floor: bool,

    /// Where the camera stands, world space [default: so far away that the whole clip is seen]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Camera")]
    pub camera: Option<Vector>,
    /// Point that the camera looks at, world space [default: middle of the clip]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Camera")]
    pub target: Option<Vector>,
    /// Angle of the automatic camera about the up axis, -360 to 360; 0 looks along -z, 90 along -x
    #[arg(long, value_name = "DEGREES", default_value_t = CameraPlace::DEFAULT_YAW_DEG, value_parser = |text: &str| values::degrees(text, -360.0, 360.0), allow_hyphen_values = true, conflicts_with = "camera", help_heading = "Camera")]
    pub yaw: f64,
    /// Angle by which the automatic camera looks down, -89 to 89
    #[arg(long, value_name = "DEGREES", default_value_t = CameraPlace::DEFAULT_PITCH_DEG, value_parser = |text: &str| values::degrees(text, -89.0, 89.0), allow_hyphen_values = true, conflicts_with = "camera", help_heading = "Camera")]
    pub pitch: f64,
    /// Vertical angle of view, 1 to 150
    #[arg(long, value_name = "DEGREES", default_value_t = CameraPlace::DEFAULT_FOV_DEG, value_parser = |text: &str| values::degrees(text, 1.0, 150.0), help_heading = "Camera")]
    pub fov: f64,
}

/// What pictures show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// One light, hard shadows
    Shaded,
    /// A colour per cluster
    Clusters,
    /// The clusters' boxes over the shaded picture
    Boxes,
    /// Heat map of the work per ray: traversal steps plus tests of boxes and triangles
    Steps,
}

impl View {
    /// All views.
    pub const ALL: [Self; 4] = [Self::Shaded, Self::Clusters, Self::Boxes, Self::Steps];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Clusters => "clusters",
            Self::Boxes => "boxes",
            Self::Steps => "steps",
        }
    }
}

/// Rays per pixel, on a fixed pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SamplesPerPixel {
    #[value(name = "1")]
    One,
    #[value(name = "4")]
    Four,
    #[value(name = "16")]
    Sixteen,
}

impl SamplesPerPixel {
    /// Samples along each side of the pattern.
    pub fn side(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 2,
            Self::Sixteen => 4,
        }
    }
}
