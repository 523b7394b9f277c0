use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// An animation clip. Its name is in the metadata.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClipRow {
    /// First key's time over all channels, seconds.
    pub start_seconds: f32,
    /// Last key's time over all channels, seconds.
    pub end_seconds: f32,
    /// First channel row.
    pub channel_first: u32,
    /// Channel rows.
    pub channel_count: u32,
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Path {
    /// Translation of a node: 3 values.
    Translation = 0,
    /// Rotation of a node, quaternion x y z w: 4 values.
    Rotation = 1,
    /// Scale of a node: 3 values.
    Scale = 2,
    /// Weights of a morph set: one value per target.
    Weights = 3,
    /// Frame of a vertex cache, counted from 0, fractions between frames: 1 value.
    Frame = 4,
}

impl Path {
    /// All paths, in the order of their numbers.
    pub const ALL: [Self; 5] = [
        Self::Translation,
        Self::Rotation,
        Self::Scale,
        Self::Weights,
        Self::Frame,
    ];

    /// The path with this number.
    #[inline]
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|path| *path as u32 == number)
    }
}

/// How values between keys follow from the keys (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Interpolation {
    /// The value of the last key that is not later.
    Step = 0,
    /// Linear; rotations spherically.
    Linear = 1,
    /// Cubic Hermite; each key holds in-tangent, value, out-tangent.
    CubicSpline = 2,
}

impl Interpolation {
    /// All interpolations, in the order of their numbers.
    pub const ALL: [Self; 3] = [Self::Step, Self::Linear, Self::CubicSpline];

    /// The interpolation with this number.
    #[inline]
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|interpolation| *interpolation as u32 == number)
    }

    /// Values stored per key, in units of the path's width.
    #[inline]
    #[must_use]
    pub fn values_per_key(self) -> u32 {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// One animated property in one clip.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ChannelRow {
    /// Node row; morph set row when `path` is weights; cache row when it is a frame.
    pub target: u32,
    /// [`Path`] as a number.
    pub path: u32,
    /// [`Interpolation`] as a number.
    pub interpolation: u32,
    /// Values of one key and one tangent: 3, 4, or the number of morph targets.
    pub width: u32,
    /// First row in the key-time section; times increase strictly.
    pub time_first: u32,
    /// Keys; at least one.
    pub key_count: u32,
    /// First row in the key-value section; `key_count · values_per_key · width` rows follow.
    pub value_first: u32,
    /// Zero.
    pub reserved: u32,
}

/// One pose from which the fuzzy boxes were made.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SampleRow {
    /// Clip row, or `NONE` for the pose without any clip.
    pub clip: u32,
    /// Time in that clip, seconds.
    pub seconds: f32,
}

/// Where the triangles of an asset are during a clip.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClipBoundsRow {
    /// Contains, in exact arithmetic, every mix `Σ w·(X·p)` of every vertex of every triangle with area, in asset space: at
    /// every time of the clip, with the palette and the morph weights of that time as rounded to `f32`.
    /// [`Aabb::EMPTY`] where nothing is known.
    pub bounds: Aabb,
    /// Bounds, per axis, the magnitudes `|X|·|p| + |t|` that enter these mixes, for every bone and every vertex that it
    /// moves: rounding at run time is relative to them. Zero where nothing is known.
    pub reach: [f32; 3],
    /// Bounds `|p₀| + |p₁| + |p₂|` of every `p`, a rest position as morphed, term by term. Zero where nothing is known.
    pub rest_reach: f32,
    /// 1 where `bounds` holds, 0 where nothing is known.
    pub known: u32,
}

impl ClipBoundsRow {
    /// The row of a clip that nothing bounds.
    pub const UNKNOWN: Self = Self {
        bounds: Aabb::EMPTY,
        reach: [0.0; 3],
        rest_reach: 0.0,
        known: 0,
    };

    /// The row of a clip that stays within `bounds`; fields as they are named.
    #[must_use]
    pub fn within(bounds: Aabb, reach: [f32; 3], rest_reach: f32) -> Self {
        Self {
            bounds,
            reach,
            rest_reach,
            known: 1,
        }
    }

    /// True where the bounds hold.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.known != 0
    }
}
