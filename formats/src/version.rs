use std::fmt;

/// The versions of the format, oldest first. Values are never renumbered and never removed.
///
/// The major number rises when a reader of the older version would misread the file, the minor number when it
/// would have to refuse it for a lack. What may be skipped is added without a new version, as an optional
/// section or an optional-feature bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FormatVersion {
    /// Static, rigid and skinned parts, morph targets, clips, fuzzy kd-trees over sampled boxes. Written by no release,
    /// and no longer read.
    V1_0,
    /// Adds vertex caches, with their tracks and time segments. Written by no release, and no longer read.
    V1_1,
    /// Adds pose spaces: boxes that hold for every pose. Written by no release, and no longer read.
    V1_2,
    /// Adds wide fuzzy trees, boxes of their nodes at key frames, bounds of stretches of clips, and boxes of what bones move in
    /// place of extents.
    V1_3,
}

impl FormatVersion {
    /// What this library writes.
    pub const LATEST: Self = Self::V1_3;

    /// What this library reads.
    pub const READABLE: &'static [Self] = &[Self::V1_3];

    /// Major and minor number.
    #[must_use]
    pub fn numbers(self) -> (u16, u16) {
        match self {
            Self::V1_0 => (1, 0),
            Self::V1_1 => (1, 1),
            Self::V1_2 => (1, 2),
            Self::V1_3 => (1, 3),
        }
    }

    /// The readable version with these numbers.
    #[must_use]
    pub fn from_numbers(major: u16, minor: u16) -> Option<Self> {
        Self::READABLE
            .iter()
            .copied()
            .find(|version| version.numbers() == (major, minor))
    }
}

impl fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (major, minor) = self.numbers();
        write!(f, "{major}.{minor}")
    }
}
