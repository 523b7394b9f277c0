//! Waves that run through soft flesh.

use crate::rotation::sin_turn;
use glam::DVec3;

/// A knock that sends a decaying wave through the flesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knock {
    /// When, seconds.
    pub seconds: f64,
    /// Where on the body at rest.
    pub place: DVec3,
    /// Height of the wave where and when it starts, scene units.
    pub height: f64,
}

/// Speed of the waves, scene units per second.
const SPEED: f64 = 2.6;
/// Waves that pass a point in a second.
const PITCH: f64 = 3.4;
/// Seconds after which a wave has fallen to 1/e.
const FADE: f64 = 0.4;

impl Knock {
    /// How far flesh at `rest` bulges outwards at a time, scene units.
    pub fn bulge(&self, rest: DVec3, seconds: f64) -> f64 {
        let since = seconds - self.seconds - rest.distance(self.place) / SPEED;
        if since <= 0.0 {
            return 0.0;
        }
        self.height * libm::exp(-since / FADE) * sin_turn(PITCH * since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_arrives_later_farther_away_and_fades() {
        let knock = Knock {
            seconds: 1.0,
            place: DVec3::ZERO,
            height: 0.1,
        };
        let far = DVec3::new(SPEED, 0.0, 0.0);
        assert_eq!(knock.bulge(DVec3::ZERO, 1.0), 0.0);
        assert_eq!(knock.bulge(far, 1.9), 0.0);
        // The same up to the rounding of the two times.
        assert!((knock.bulge(far, 2.05) - knock.bulge(DVec3::ZERO, 1.05)).abs() < 1e-15);
        let crest = 0.25 / PITCH;
        assert!(knock.bulge(DVec3::ZERO, 1.0 + crest) > 0.08);
        assert!(knock.bulge(DVec3::ZERO, 9.0).abs() < 1e-9);
    }
}
