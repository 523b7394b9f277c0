use super::JointLimits;

/// The poses that the boxes are made for, beside the pose without any clip, which is always one of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PoseSpace {
    /// All clips of the file, and random poses in which every joint has any rotation, uniform on the sphere of
    /// rotations; translations and scales are those without any clip.
    Arbitrary,
    /// All clips of the file, and random poses in which every joint has any rotation within limits.
    Limits(LimitSettings),
    /// All clips of the file.
    #[default]
    Clips,
    /// One clip of the file, by name, or by number in the source; clips of one name together. The other clips stay in
    /// the file and can be played.
    Clip(String),
}

/// How far joints turn in [`PoseSpace::Limits`].
#[derive(Clone, Debug, PartialEq)]
pub struct LimitSettings {
    /// Joints whose limits are known. The default names none.
    pub joints: JointLimits,
    /// The others' limits are what their rotation vectors reach in the clips, about each axis, and this much more on both
    /// sides; degrees, 0 to 180; default 10. Limits end at half a turn to either side.
    pub slack_deg: f64,
}

impl Default for LimitSettings {
    fn default() -> Self {
        Self {
            joints: JointLimits::default(),
            slack_deg: 10.0,
        }
    }
}

impl PoseSpace {
    /// Random poses, where the user does not say how many. Source: Günther, *Ray Tracing of Dynamic Scenes*, Table 3.1.
    #[must_use]
    pub fn default_samples(&self) -> usize {
        match self {
            Self::Arbitrary => 1000,
            Self::Limits(_) => 245,
            Self::Clips | Self::Clip(_) => 0,
        }
    }

    /// Its name, as the options of a file keep it.
    pub(crate) fn listed(&self) -> String {
        match self {
            Self::Arbitrary => "arbitrary".to_owned(),
            Self::Limits(_) => "limits".to_owned(),
            Self::Clips => "clips".to_owned(),
            Self::Clip(name) => format!("clip {name:?}"),
        }
    }

    /// Whether random poses are part of it.
    #[must_use]
    pub fn is_random(&self) -> bool {
        matches!(self, Self::Arbitrary | Self::Limits(_))
    }
}
