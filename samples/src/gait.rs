//! Legs that walk: where a foot is in its cycle, and the joint angles that put it there.

use crate::rotation::{about_x, sin_turn};
use glam::{DQuat, DVec3};

/// Rotations about x, in degrees, of a leg's two segments; zero hangs straight down, positive swings back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegAngles {
    /// Upper segment.
    pub upper: f64,
    /// Lower segment.
    pub lower: f64,
}

impl LegAngles {
    /// The upper segment's rotation in figure space.
    pub fn upper_rotation(self) -> DQuat {
        about_x(self.upper)
    }

    /// The lower segment's rotation in figure space.
    pub fn lower_rotation(self) -> DQuat {
        about_x(self.lower)
    }
}

/// The angles that bring the end of a two-segment leg from `hip` to `ankle` within the plane of y and z, or as near as
/// its length allows. The knee points forward (+z) where `knee_sign` is 1 and backward where it is -1.
pub fn reach(hip: DVec3, ankle: DVec3, lengths: [f64; 2], knee_sign: f64) -> LegAngles {
    let [upper, lower] = lengths;
    let (down, back) = (hip.y - ankle.y, hip.z - ankle.z);
    // A leg that is never quite straight keeps its knee from snapping.
    let longest = (upper + lower) * 0.999;
    let reached = (down * down + back * back)
        .sqrt()
        .clamp((upper - lower).abs() * 1.001, longest);
    let straight = libm::atan2(back, down);
    let knee = (upper * upper + reached * reached - lower * lower) / (2.0 * upper * reached);
    let upper_angle = straight - knee_sign * libm::acos(knee.clamp(-1.0, 1.0));
    let (knee_down, knee_back) = (upper * libm::cos(upper_angle), upper * libm::sin(upper_angle));
    let (end_down, end_back) = (reached * libm::cos(straight), reached * libm::sin(straight));
    let lower_angle = libm::atan2(end_back - knee_back, end_down - knee_down);
    LegAngles {
        upper: upper_angle.to_degrees(),
        lower: lower_angle.to_degrees(),
    }
}

/// One foot's way around its cycle.
#[derive(Clone, Copy, Debug)]
pub struct Stride {
    /// Part of the cycle on the ground.
    pub stance: f64,
    /// Where the foot lands, ahead of its rest position, scene units.
    pub front: f64,
    /// Where the foot leaves the ground, behind its rest position.
    pub back: f64,
    /// How high it is lifted.
    pub lift: f64,
}

impl Stride {
    /// Offset from the rest position: up (y) and ahead (z), at a phase of the cycle in turns; it lands at phase 0 and
    /// moves evenly over the ground.
    pub fn offset(&self, phase: f64) -> DVec3 {
        let phase = phase - phase.floor();
        if phase < self.stance {
            let ahead = self.front - (self.front + self.back) * (phase / self.stance);
            return DVec3::new(0.0, 0.0, ahead);
        }
        let swing = (phase - self.stance) / (1.0 - self.stance);
        let eased = swing * swing * (3.0 - 2.0 * swing);
        let ahead = (self.front + self.back) * eased - self.back;
        DVec3::new(0.0, self.lift * sin_turn(swing * 0.5), ahead)
    }
}

/// Linear interpolation in a table of (phase, value) that ascends from phase 0 to phase 1.
pub fn table(entries: &[(f64, f64)], phase: f64) -> f64 {
    let phase = phase - phase.floor();
    for pair in entries.windows(2) {
        let ((start, from), (end, to)) = (pair[0], pair[1]);
        if phase <= end {
            return from + (to - from) * (phase - start) / (end - start);
        }
    }
    entries.last().map_or(0.0, |&(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_reaches_what_it_can() {
        let (hip, ankle) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 0.2, 0.3));
        for knee_sign in [1.0, -1.0] {
            let angles = reach(hip, ankle, [0.5, 0.45], knee_sign);
            let knee = hip + angles.upper_rotation() * DVec3::new(0.0, -0.5, 0.0);
            let end = knee + angles.lower_rotation() * DVec3::new(0.0, -0.45, 0.0);
            // A dozen roundings of numbers near one.
            assert!(end.distance(ankle) < 1e-14);
            let bulge = knee.z - (hip.z + ankle.z) * 0.5;
            assert_eq!(bulge > 0.0, knee_sign > 0.0);
        }
    }

    #[test]
    fn a_stride_is_continuous_and_on_the_ground_in_stance() {
        let stride = Stride {
            stance: 0.6,
            front: 0.3,
            back: 0.2,
            lift: 0.1,
        };
        assert_eq!(stride.offset(0.0), DVec3::new(0.0, 0.0, 0.3));
        assert_eq!(stride.offset(0.3).y, 0.0);
        assert!(stride.offset(0.8).y > 0.09);
        assert!(stride.offset(0.6).distance(stride.offset(0.600_001)) < 1e-5);
        assert!(stride.offset(1.0).distance(stride.offset(0.999_999)) < 1e-5);
    }

    #[test]
    fn table_interpolates() {
        assert_eq!(table(&[(0.0, 1.0), (0.5, 3.0), (1.0, 1.0)], 0.25), 2.0);
        assert_eq!(table(&[(0.0, 1.0), (0.5, 3.0), (1.0, 1.0)], 1.75), 2.0);
    }
}
