//! How the goose of `goose.obj` holds itself in each frame: it waits, crouches, heads the ball, lands, shakes.

use crate::curve::eased;
use crate::gait::reach;
use crate::goose_body::{BONE_COUNT, HEAD, NECK, SIDES, Side, TAIL, TRUNK};
use crate::rotation::{about_x, about_y, about_z, sin_turn};
use crate::skinning::Bone;
use glam::{DMat3, DQuat, DVec3};

/// The frame in which the head meets the ball.
pub const HEADER: f64 = 36.0;
/// The frame in which the feet are back on the ground.
pub const LANDING: f64 = 43.0;

const CROUCH: [(f64, f64); 11] = [
    (0.0, 0.1),
    (12.0, 0.25),
    (22.0, 0.1),
    (31.0, 1.0),
    (33.0, 0.95),
    (HEADER, -0.35),
    (40.0, 0.0),
    (46.0, 1.1),
    (51.0, -0.15),
    (57.0, 0.3),
    (64.0, 0.1),
];
/// How high it hops, scene units.
const HOP: [(f64, f64); 4] = [(33.0, 0.0), (36.5, 0.26), (38.5, 0.24), (LANDING, 0.0)];
const NECK_LENGTH: [(f64, f64); 12] = [
    (0.0, 1.0),
    (24.0, 1.05),
    (31.0, 0.6),
    (33.0, 0.62),
    (HEADER, 2.9),
    (37.0, 3.0),
    (39.0, 1.7),
    (41.0, 0.6),
    (45.0, 1.3),
    (49.0, 0.85),
    (53.0, 1.1),
    (58.0, 1.0),
];
/// Degrees by which the neck leans forward.
const LEAN_DEG: [(f64, f64); 9] = [
    (0.0, -6.0),
    (20.0, -2.0),
    (31.0, -34.0),
    (33.0, -30.0),
    (HEADER, 22.0),
    (41.0, 34.0),
    (47.0, -14.0),
    (53.0, 10.0),
    (60.0, -4.0),
];
/// Degrees by which head and neck turn to its left, after the ball.
const LOOK_DEG: [(f64, f64); 7] = [
    (0.0, -46.0),
    (14.0, -34.0),
    (31.0, 0.0),
    (40.0, 0.0),
    (50.0, 30.0),
    (64.0, 48.0),
    (84.0, 58.0),
];
/// Degrees by which the wings are raised from where they are spread.
const WINGS_DEG: [(f64, f64); 12] = [
    (0.0, -52.0),
    (25.0, -50.0),
    (32.0, -20.0),
    (HEADER, 48.0),
    (39.0, -34.0),
    (41.5, 36.0),
    (44.0, -36.0),
    (47.0, 26.0),
    (50.0, -30.0),
    (53.0, 6.0),
    (58.0, -48.0),
    (66.0, -54.0),
];

/// Where a bone takes the points of the goose at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoneMap {
    joint: DVec3,
    rest_joint: DVec3,
    linear: DMat3,
}

impl BoneMap {
    /// The image of a point.
    pub fn place(&self, rest: DVec3) -> DVec3 {
        self.joint + self.linear * (rest - self.rest_joint)
    }
}

/// One map per bone. Time in frames.
pub fn pose(bones: &[Bone], time: f64) -> Vec<BoneMap> {
    let crouch = eased(&CROUCH, time);
    let hop = eased(&HOP, time);
    let place = bones[TRUNK].joint + DVec3::new(0.0, hop - 0.15 * crouch.max(-0.1), -0.03 * crouch);
    let mut turns = turns(time);
    let mut stretches = vec![DMat3::IDENTITY; BONE_COUNT];
    stretches[TRUNK] = stretch(DVec3::Y, 1.0 - 0.3 * crouch);
    let length = eased(&NECK_LENGTH, time);
    for (bone, next) in NECK.into_iter().zip([NECK[1], NECK[2], HEAD]) {
        stretches[bone] = stretch((bones[next].joint - bones[bone].joint).normalize(), length);
    }
    // The head gives way a little to the neck's pull and to the ball.
    stretches[HEAD] = stretch(DVec3::Y, 1.0 + 0.12 * (length - 1.0).min(1.0));

    let trunk = BoneMap {
        joint: place,
        rest_joint: bones[TRUNK].joint,
        linear: DMat3::from_quat(turns[TRUNK]) * stretches[TRUNK],
    };
    for side in SIDES {
        bend_leg(bones, side, &trunk, hop, &mut turns);
    }
    let mut maps: Vec<BoneMap> = Vec::with_capacity(bones.len());
    for (number, bone) in bones.iter().enumerate() {
        let parent = bone.parent.and_then(|parent| maps.get(parent));
        maps.push(BoneMap {
            joint: parent.map_or(place, |parent| parent.place(bone.joint)),
            rest_joint: bone.joint,
            linear: DMat3::from_quat(turns[number]) * stretches[number],
        });
    }
    // Feet stand flat where they stood, however wide the hips have become.
    for side in SIDES {
        maps[side.foot].joint = bones[side.foot].joint + DVec3::Y * hop;
    }
    maps
}

/// How far each bone but those of the legs is turned from rest, in space.
fn turns(time: f64) -> Vec<DQuat> {
    let seconds = time / 24.0;
    let mut turns = vec![DQuat::IDENTITY; BONE_COUNT];
    turns[TRUNK] = about_y(0.15 * eased(&LOOK_DEG, time)) * about_z(3.0 * sin_turn(0.6 * seconds));
    let (lean, look) = (eased(&LEAN_DEG, time), eased(&LOOK_DEG, time));
    for (number, bone) in NECK.into_iter().enumerate() {
        let along = (number + 1) as f64 / 4.0;
        let sway = 5.0 * sin_turn(0.9 * seconds - 0.15 * along);
        // An S at ease, a straight line when it strikes.
        let ess = 26.0 * (0.5 - along) * (2.0 - eased(&NECK_LENGTH, time)).clamp(0.0, 1.0);
        turns[bone] = about_y(look * along) * about_z(sway * along) * about_x(lean + ess);
    }
    turns[HEAD] = about_y(look) * about_x(0.35 * lean + 6.0 * sin_turn(0.7 * seconds));
    turns[TAIL] = turns[TRUNK] * about_y(24.0 * sin_turn(2.2 * seconds)) * about_x(-0.5 * lean);
    for side in SIDES {
        let lift = |late: f64| about_z(side.sign * eased(&WINGS_DEG, time - late));
        let flutter = about_x(side.sign * 4.0 * sin_turn(1.3 * seconds));
        turns[side.wing] = turns[TRUNK] * lift(0.0) * flutter;
        // The tips follow later and so swing farther.
        turns[side.wing_tip] = turns[side.wing] * lift(0.0).inverse() * lift(1.6) * about_z(side.sign * -14.0);
    }
    turns
}

fn bend_leg(bones: &[Bone], side: Side, trunk: &BoneMap, hop: f64, turns: &mut [DQuat]) {
    let [hip, knee, ankle] = [side.thigh, side.shank, side.foot].map(|bone| bones[bone].joint);
    let lengths = [hip.distance(knee), knee.distance(ankle)];
    let rest = reach(hip, ankle, lengths, -1.0);
    let now = reach(trunk.place(hip), ankle + DVec3::Y * hop, lengths, -1.0);
    turns[side.thigh] = about_x(now.upper - rest.upper);
    turns[side.shank] = about_x(now.lower - rest.lower);
}

/// Longer along an axis by `factor`, thinner across it by as much as keeps the volume.
fn stretch(axis: DVec3, factor: f64) -> DMat3 {
    let across = 1.0 / factor.sqrt();
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    DMat3::from_diagonal(DVec3::splat(across)) + along * (factor - across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::goose_body::goose;

    #[test]
    fn stretching_keeps_the_volume() {
        let axis = DVec3::new(0.6, 0.0, 0.8);
        let map = stretch(axis, 3.0);
        // A dozen roundings of numbers up to three.
        assert!((map.determinant() - 1.0).abs() < 1e-14);
        assert!((map * axis).distance(axis * 3.0) < 1e-14);
    }

    #[test]
    fn feet_stand_where_they_stood_and_leave_the_ground_in_the_hop() {
        let bones = goose().bones;
        for (time, height) in [(0.0, 0.0), (31.0, 0.0), (36.5, 0.26), (60.0, 0.0)] {
            for side in SIDES {
                let foot = pose(&bones, time)[side.foot];
                let expected = bones[side.foot].joint + DVec3::Y * height;
                assert!(foot.place(bones[side.foot].joint).distance(expected) < 1e-14, "{time}");
            }
        }
    }

    #[test]
    fn the_neck_stretches_in_a_few_frames_to_thrice_its_length() {
        let bones = goose().bones;
        let length = |time| {
            let maps = pose(&bones, time);
            maps[HEAD].joint.distance(maps[NECK[0]].joint)
        };
        assert!(length(HEADER) > 4.0 * length(HEADER - 3.0));
        assert!(length(HEADER) > 4.0 * length(HEADER + 5.0));
    }
}
