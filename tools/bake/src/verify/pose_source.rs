use serde::Serialize;

/// Where the poses of a verification come from. Vertex caches stand at random times in all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseSource {
    /// The file's samples, spread evenly: the poses that sampled boxes are made of.
    Samples,
    /// The file's clips at random times, every fourth at a key.
    Clips,
    /// Poses far outside any clip, of all families in turn.
    Random,
}

/// A family of random poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseFamily {
    /// Every joint's rotation drawn from all rotations alike; translations and scales of a clip.
    Ragdoll,
    /// Every joint turned by up to [`SMALL_TURN_DEG`] about any axis, as inverse kinematics does.
    SmallTurns,
    /// The maps of two poses of clips, blended entry by entry.
    Blend,
    /// Every node as in another clip and at another time.
    Mix,
    /// A few bones scaled unevenly in their own axes, by factors of 1/64 to 64.
    Scaled,
    /// A few bones sheared in their own axes, by factors of up to three.
    Sheared,
    /// A few bones mirrored at a plane through their joint.
    Mirrored,
    /// One bone scaled to zero, flattened to a plane or a line, or scaled by 1e-30.
    Vanished,
    /// One bone moved by a thousand times the model's size.
    Far,
    /// A few bones flattened to a condition of 1e4 to 1e7.
    NearSingular,
    /// Morph weights from −2 to 3.
    Morphs,
}

/// Largest angle of [`PoseFamily::SmallTurns`].
pub const SMALL_TURN_DEG: f64 = 20.0;

impl PoseFamily {
    /// All families, in the order in which they take turns.
    pub const ALL: [Self; 11] = [
        Self::Ragdoll,
        Self::SmallTurns,
        Self::Blend,
        Self::Mix,
        Self::Scaled,
        Self::Sheared,
        Self::Mirrored,
        Self::Vanished,
        Self::Far,
        Self::NearSingular,
        Self::Morphs,
    ];

    /// The family's name, as reports print it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ragdoll => "ragdoll",
            Self::SmallTurns => "small_turns",
            Self::Blend => "blend",
            Self::Mix => "mix",
            Self::Scaled => "scaled",
            Self::Sheared => "sheared",
            Self::Mirrored => "mirrored",
            Self::Vanished => "vanished",
            Self::Far => "far",
            Self::NearSingular => "near_singular",
            Self::Morphs => "morphs",
        }
    }
}
