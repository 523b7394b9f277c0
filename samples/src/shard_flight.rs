//! The way of a shard: it breaks off, tumbles through the air, bounces once on the ground at y = 0 and lies flat.

use crate::ball_flight::GRAVITY;
use crate::rotation::about;
use crate::vase::Shard;
use glam::{DQuat, DVec3};

/// What a bounce leaves of the speed, upwards and along the ground.
const BOUNCE: [f64; 2] = [0.35, 0.5];

/// How a shard is thrown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throw {
    /// When it breaks off, seconds.
    pub seconds: f64,
    /// Its first velocity, scene units per second.
    pub velocity: DVec3,
    /// Unit axis of its spin.
    pub axis: DVec3,
    /// Spin, degrees per second.
    pub spin_deg: f64,
}

/// Where the corners of a shard are at a time, scene units.
///
/// Guarantee: exactly where they were until it breaks off; moved by one rigid motion and not below the ground after.
pub fn thrown(shard: &Shard, throw: &Throw, seconds: f64) -> [DVec3; 6] {
    let since = seconds - throw.seconds;
    if since <= 0.0 {
        return shard.corners;
    }
    let middle = shard.middle();
    let arms = shard.corners.map(|corner| corner - middle);
    let lowest = |turn: DQuat| arms.iter().map(|arm| (turn * *arm).y).fold(f64::INFINITY, f64::min);
    let ground = DVec3::new(1.0, 0.0, 1.0);

    let landing = landing(throw, middle.y);
    let tumbled = about(throw.axis, throw.spin_deg * since.min(landing));
    let (mut centre, mut turn) = (fallen(middle, throw.velocity, since.min(landing)), tumbled);
    if since > landing {
        let flat = flattening(tumbled * shard.outward());
        let speed = GRAVITY * landing - throw.velocity.y;
        let bounced = throw.velocity * ground * BOUNCE[1] + DVec3::Y * (speed.max(0.0) * BOUNCE[0]);
        let flight = 2.0 * bounced.y / GRAVITY;
        let along = (since - landing).min(flight);
        centre = fallen(centre, bounced, along);
        let share = if flight > 0.0 { along / flight } else { 1.0 };
        turn = about(flat.0, flat.1 * share) * tumbled;
    }
    centre.y = centre.y.max(-lowest(turn));
    arms.map(|arm| centre + turn * arm)
}

/// Seconds from its breaking off until a shard's middle, at this height, is at the ground.
fn landing(throw: &Throw, height: f64) -> f64 {
    let up = throw.velocity.y;
    (up + (up * up + 2.0 * GRAVITY * height.max(0.0)).sqrt()) / GRAVITY
}

fn fallen(from: DVec3, velocity: DVec3, seconds: f64) -> DVec3 {
    from + velocity * seconds - DVec3::Y * (0.5 * GRAVITY * seconds * seconds)
}

/// Unit axis and degrees of the shortest turn that makes a unit normal point up or down.
fn flattening(normal: DVec3) -> (DVec3, f64) {
    let target = DVec3::Y * normal.y.signum();
    let axis = normal.cross(target).normalize_or(DVec3::X);
    (axis, libm::acos(normal.dot(target).min(1.0)).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vase::shards;

    const THROW: Throw = Throw {
        seconds: 0.25,
        velocity: DVec3::new(1.0, 2.0, -0.5),
        axis: DVec3::new(0.6, 0.0, 0.8),
        spin_deg: 300.0,
    };

    #[test]
    fn a_shard_stays_itself_and_above_the_ground() {
        for shard in shards().iter().step_by(97) {
            assert_eq!(thrown(shard, &THROW, 0.25), shard.corners);
            for step in 1..60 {
                let now = thrown(shard, &THROW, 0.25 + f64::from(step) * 0.02);
                assert!(now.iter().all(|corner| corner.y > -1e-15), "{now:?}");
                for (a, b) in (0..6).zip(1..6) {
                    let change = now[a].distance(now[b]) - shard.corners[a].distance(shard.corners[b]);
                    // A handful of roundings of numbers of about one.
                    assert!(change.abs() < 1e-14, "{change}");
                }
            }
        }
    }

    #[test]
    fn a_shard_falls_freely_then_lies_flat() {
        let shard = shards()[1_000];
        let middle = |seconds: f64| thrown(&shard, &THROW, seconds).iter().sum::<DVec3>() / 6.0;
        let (h, t) = (1e-3, 0.4);
        let fall = (middle(t + h) + middle(t - h) - 2.0 * middle(t)) / (h * h);
        // Second differences of numbers near one over a millionth.
        assert!(fall.distance(DVec3::NEG_Y * GRAVITY) < 1e-8, "{fall}");
        let end = thrown(&shard, &THROW, 9.0);
        assert_eq!(end, thrown(&shard, &THROW, 10.0));
        let [a, b, c, ..] = end;
        // The sine of the angle at which it lies: acos loses half of the digits near one.
        assert!((a.y - b.y).abs().max((b.y - c.y).abs()) < 1e-8, "{end:?}");
        let lowest = end.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        assert!(lowest.abs() < 1e-15, "{lowest}");
    }
}
