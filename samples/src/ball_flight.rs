//! The way of a thrown ball: parabolas from one bounce to the next, an even spin along each.

use crate::rotation::about;
use glam::{DQuat, DVec3};

/// Gravity, scene units per second squared.
pub const GRAVITY: f64 = 9.8;

/// A bounce, or one end of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// When, seconds.
    pub seconds: f64,
    /// Where the ball's centre is.
    pub centre: DVec3,
    /// Unit axis of its spin from here on.
    pub axis: DVec3,
    /// Spin from here on, degrees per second.
    pub spin_deg: f64,
}

/// Centre and turn at a time, between the first bounce and the last.
pub fn flight(bounces: &[Bounce], seconds: f64) -> (DVec3, DQuat) {
    let mut turn = DQuat::IDENTITY;
    let mut centre = bounces.first().map_or(DVec3::ZERO, |bounce| bounce.centre);
    for pair in bounces.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let whole = to.seconds - from.seconds;
        let since = (seconds - from.seconds).clamp(0.0, whole);
        turn = about(from.axis, from.spin_deg * since) * turn;
        centre = from.centre.lerp(to.centre, since / whole) + DVec3::Y * (0.5 * GRAVITY * since * (whole - since));
        if seconds <= to.seconds {
            break;
        }
    }
    (centre, turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_meets_its_bounces_and_falls_freely_between() {
        let bounce = |seconds, x, spin_deg| Bounce {
            seconds,
            centre: DVec3::new(x, 1.0, 0.0),
            axis: DVec3::Z,
            spin_deg,
        };
        let bounces = [bounce(0.0, 0.0, 90.0), bounce(1.0, 2.0, -90.0), bounce(3.0, 2.0, 0.0)];
        let centre = |seconds| flight(&bounces, seconds).0;
        assert_eq!([0.0, 1.0, 3.0].map(centre), bounces.map(|bounce| bounce.centre));
        let (h, t) = (1e-3, 0.4);
        let fall = (centre(t + h) + centre(t - h) - 2.0 * centre(t)) / (h * h);
        // Second differences of numbers near one over a millionth.
        assert!(fall.distance(DVec3::new(0.0, -GRAVITY, 0.0)) < 1e-8, "{fall}");
        let quarter = flight(&bounces, 1.0).1 * DVec3::X;
        assert!(quarter.distance(DVec3::Y) < 1e-15);
        let back = flight(&bounces, 2.0).1 * DVec3::X;
        assert!(back.distance(DVec3::X) < 1e-15);
    }
}
