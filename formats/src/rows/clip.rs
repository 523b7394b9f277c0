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

/// Stretches of equal length that a clip's time is divided into, for bounds of each.
pub const STRETCHES: usize = 32;

impl ClipRow {
    /// The stretch that a time falls into, counted from 0: below [`STRETCHES`]. This is what divides a clip, and not any
    /// border between the stretches: it is computed in `f32`, as written in `FORMAT.md`, so that all who compute it agree.
    ///
    /// Guarantee: a later time is in no earlier stretch. Times before the clip are in its first one, times after it in the
    /// last; all times of a clip without length, and a NaN, are in the first. So are those of a clip whose length, or
    /// stretches per second, are beyond `f32`.
    #[inline]
    #[must_use]
    pub fn stretch(&self, seconds: f32) -> usize {
        let rate = STRETCHES as f32 / (self.end_seconds - self.start_seconds);
        let rate = if rate.is_finite() { rate } else { 0.0 };
        // The cast saturates, and makes a NaN zero.
        let place = ((seconds - self.start_seconds) * rate) as usize;
        place.min(STRETCHES - 1)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{
        num::f32::{NORMAL, SUBNORMAL, ZERO},
        prelude::*,
    };

    fn clip(start_seconds: f32, end_seconds: f32) -> ClipRow {
        ClipRow {
            start_seconds,
            end_seconds,
            channel_first: 0,
            channel_count: 1,
        }
    }

    #[test]
    fn stretches_divide_a_clip_evenly() {
        let clip = clip(-1.0, 3.0);
        for stretch in 0..STRETCHES {
            let begin = -1.0 + stretch as f32 * 0.125;
            assert_eq!(clip.stretch(begin), stretch);
            assert_eq!(clip.stretch(begin + 0.1), stretch);
        }
        assert_eq!(clip.stretch(3.0), STRETCHES - 1);
    }

    #[test]
    fn times_outside_of_a_clip_are_in_the_stretches_at_its_ends() {
        let clip = clip(1.0, 2.0);
        for before in [f32::NEG_INFINITY, f32::MIN, -3.0, 1f32.next_down()] {
            assert_eq!(clip.stretch(before), 0, "at {before}");
        }
        for after in [2f32.next_up(), 3.0, f32::MAX, f32::INFINITY] {
            assert_eq!(clip.stretch(after), STRETCHES - 1, "at {after}");
        }
    }

    /// Clips of no length, of too great a one, and of one that has too many stretches a second.
    #[test]
    fn clips_that_cannot_be_divided_are_all_first_stretch() {
        for clip in [clip(1.0, 1.0), clip(-3e38, 3e38), clip(0.0, 1e-40)] {
            for seconds in [f32::NAN, f32::NEG_INFINITY, f32::MIN, 0.0, 1.0, f32::MAX, f32::INFINITY] {
                assert_eq!(clip.stretch(seconds), 0, "{clip:?} at {seconds}");
            }
        }
    }

    proptest! {
        #[test]
        fn later_times_are_in_no_earlier_stretches(
            ends in [NORMAL | SUBNORMAL | ZERO, NORMAL | SUBNORMAL | ZERO],
            times in [NORMAL | SUBNORMAL | ZERO, NORMAL | SUBNORMAL | ZERO],
            part in 0f32..1.0,
        ) {
            let clip = clip(ends[0].min(ends[1]), ends[0].max(ends[1]));
            prop_assert!(clip.stretch(times[0].min(times[1])) <= clip.stretch(times[0].max(times[1])));
            // Near each other and inside of the clip, where rounding counts.
            let near = clip.start_seconds + part * (clip.end_seconds - clip.start_seconds);
            prop_assert!(clip.stretch(near) <= clip.stretch(near.next_up()));
        }
    }
}
