//! `walker.glb`: a figure that walks and waves on a small stage.

use crate::column::{Column, Component};
use crate::figure::{Skeleton, add_skinned_surface};
use crate::flat_mesh::add_flat_mesh;
use crate::gait::{Stride, reach, table};
use crate::gltf_json::Node;
use crate::gltf_writer::{GltfWriter, Track, WriteError};
use crate::limbs::{Body, Limb};
use crate::rotation::{about_x, about_y, about_z, cos_turn, sin_turn};
use crate::skinning::{Bone, influences};
use crate::solids::lathe;
use crate::surface_net::{Net, surface_of};
use glam::{DQuat, DVec3};

const HIPS: usize = 0;
const SPINE: usize = 1;
const CHEST: usize = 2;
const NECK: usize = 3;
const HEAD: usize = 4;
const BONE_COUNT: usize = 21;

/// The eight bones of one side; the left side is that of +x, for the figure looks along +z.
#[derive(Clone, Copy)]
struct Side {
    sign: f64,
    suffix: &'static str,
    shoulder: usize,
    upper_arm: usize,
    forearm: usize,
    hand: usize,
    thigh: usize,
    shin: usize,
    foot: usize,
    toe: usize,
}

const fn side(sign: f64, suffix: &'static str, first: usize) -> Side {
    Side {
        sign,
        suffix,
        shoulder: first,
        upper_arm: first + 1,
        forearm: first + 2,
        hand: first + 3,
        thigh: first + 4,
        shin: first + 5,
        foot: first + 6,
        toe: first + 7,
    }
}

const LEFT: Side = side(1.0, "left", 5);
const RIGHT: Side = side(-1.0, "right", 13);

const THIGH_LENGTH: f64 = 0.43;
const SHIN_LENGTH: f64 = 0.42;
/// From the figure's bind pose, arms half raised, to arms that hang: degrees about z.
const ARM_DROP_DEG: f64 = 38.0;
const WALK_KEYS: u32 = 16;

/// The scene's bytes.
///
/// # Errors
/// [`WriteError`] as [`GltfWriter::into_glb`] says.
pub fn walker_glb() -> Result<Vec<u8>, WriteError> {
    let mut writer = GltfWriter::new("walker");
    let cloth = writer.add_material("cloth", [0.75, 0.32, 0.16]);
    let slate = writer.add_material("slate", [0.35, 0.38, 0.42]);

    let bones = bones();
    let armature = writer.add_root(Node {
        name: "walker".to_owned(),
        ..Node::default()
    });
    let skeleton = Skeleton::add(&mut writer, armature, bones, &standing());
    let body = body(&skeleton.bones);
    let surface = surface_of(&body, &net());
    let weights: Vec<_> = surface
        .positions
        .iter()
        .map(|&point| influences(&body, &skeleton.bones, point, 0.085, 4))
        .collect();
    let skin = skeleton.add_skin(&mut writer, "walker_skin");
    add_skinned_surface(
        &mut writer,
        "walker_body",
        &surface,
        Column::vectors(&surface.normals()),
        &weights,
        Component::U8,
        (skin, cloth),
    );
    let stage = lathe(&[(0.9, -0.075), (0.93, -0.06), (0.93, -0.03), (0.9, -0.015)], 48);
    let stage = add_flat_mesh(&mut writer, "stage", &stage, slate);
    writer.add_root(Node {
        name: "stage".to_owned(),
        mesh: Some(stage),
        ..Node::default()
    });

    let (times, hips, poses) = walk(&skeleton.bones);
    let mut walk = skeleton.linear_tracks(&times, &poses);
    walk.push(Track {
        node: skeleton.nodes[HIPS],
        path: "translation",
        interpolation: "LINEAR",
        times,
        values: Column::vectors(&hips),
    });
    writer.add_clip("walk", &walk);
    let (times, poses) = wave();
    writer.add_clip("wave", &skeleton.spline_tracks(&times, &poses));
    writer.into_glb()
}

fn bones() -> Vec<Bone> {
    let bone = |name: &str, parent, joint: [f64; 3]| Bone {
        name: name.to_owned(),
        parent,
        joint: DVec3::from(joint),
    };
    let mut bones = vec![
        bone("hips", None, [0.0, 0.98, 0.0]),
        bone("spine", Some(HIPS), [0.0, 1.06, 0.0]),
        bone("chest", Some(SPINE), [0.0, 1.2, 0.0]),
        bone("neck", Some(CHEST), [0.0, 1.42, 0.0]),
        bone("head", Some(NECK), [0.0, 1.5, 0.0]),
    ];
    for side in [LEFT, RIGHT] {
        let at = |x: f64, y: f64, z: f64| [side.sign * x, y, z];
        let named = |part: &str| format!("{part}_{}", side.suffix);
        let (hip, knee) = (0.93, 0.93 - THIGH_LENGTH);
        bones.extend([
            bone(&named("shoulder"), Some(CHEST), at(0.06, 1.36, 0.0)),
            bone(&named("upper_arm"), Some(side.shoulder), at(0.19, 1.36, 0.0)),
            bone(&named("forearm"), Some(side.upper_arm), at(0.39, 1.19, 0.0)),
            bone(&named("hand"), Some(side.forearm), at(0.575, 1.03, 0.0)),
            bone(&named("thigh"), Some(HIPS), at(0.1, hip, 0.0)),
            bone(&named("shin"), Some(side.thigh), at(0.1, knee, 0.0)),
            bone(&named("foot"), Some(side.shin), at(0.1, knee - SHIN_LENGTH, 0.0)),
            bone(&named("toe"), Some(side.foot), at(0.1, 0.04, 0.13)),
        ]);
    }
    bones
}

fn body(bones: &[Bone]) -> Body {
    let limb = |bone, from: [f64; 3], to: [f64; 3], from_radius, to_radius| Limb {
        bone,
        from: DVec3::from(from),
        to: DVec3::from(to),
        from_radius,
        to_radius,
    };
    let mut limbs = vec![
        limb(HIPS, [-0.06, 0.95, 0.0], [0.06, 0.95, 0.0], 0.125, 0.125),
        limb(SPINE, [-0.035, 1.09, 0.0], [0.035, 1.09, 0.0], 0.12, 0.12),
        limb(CHEST, [-0.06, 1.25, 0.0], [0.06, 1.25, 0.0], 0.13, 0.13),
        limb(CHEST, [-0.12, 1.34, 0.0], [0.12, 1.34, 0.0], 0.08, 0.08),
        limb(NECK, [0.0, 1.42, 0.0], [0.0, 1.5, 0.01], 0.058, 0.055),
        limb(HEAD, [0.0, 1.6, 0.01], [0.0, 1.66, 0.005], 0.125, 0.132),
        limb(HEAD, [0.0, 1.61, 0.12], [0.0, 1.59, 0.165], 0.025, 0.032),
        limb(HEAD, [-0.13, 1.62, 0.0], [-0.15, 1.63, -0.01], 0.028, 0.026),
        limb(HEAD, [0.13, 1.62, 0.0], [0.15, 1.63, -0.01], 0.028, 0.026),
    ];
    for side in [LEFT, RIGHT] {
        let at = |x: f64, y: f64, z: f64| [side.sign * x, y, z];
        let joint = |bone: usize| bones[bone].joint.to_array();
        let hand = bones[side.hand].joint;
        let reach = (hand - bones[side.forearm].joint).normalize();
        let knuckles = (hand + reach * 0.09).to_array();
        let palm = hand + reach * 0.03;
        let thumb = palm + DVec3::new(0.0, -0.01, 0.065) + reach * 0.03;
        let (upper_arm, forearm) = (joint(side.upper_arm), joint(side.forearm));
        limbs.extend([
            limb(side.shoulder, at(0.1, 1.355, 0.0), upper_arm, 0.075, 0.072),
            limb(side.upper_arm, upper_arm, forearm, 0.068, 0.055),
            limb(side.forearm, forearm, joint(side.hand), 0.055, 0.043),
            limb(side.hand, joint(side.hand), knuckles, 0.043, 0.05),
            limb(side.hand, palm.to_array(), thumb.to_array(), 0.028, 0.022),
            limb(side.thigh, joint(side.thigh), joint(side.shin), 0.1, 0.066),
            limb(side.shin, at(0.1, 0.5, 0.0), at(0.1, 0.36, -0.012), 0.07, 0.066),
            limb(side.shin, at(0.1, 0.36, -0.012), at(0.1, 0.1, 0.0), 0.066, 0.048),
            limb(side.foot, at(0.1, 0.075, 0.0), at(0.1, 0.05, 0.11), 0.052, 0.05),
            limb(side.foot, at(0.1, 0.055, -0.035), at(0.1, 0.05, 0.0), 0.05, 0.05),
            limb(side.toe, at(0.1, 0.045, 0.13), at(0.105, 0.042, 0.185), 0.047, 0.042),
        ]);
    }
    Body { limbs, blend: 0.045 }
}

fn net() -> Net {
    // The middle plane is a plane of the grid, so that the net is its own mirror image.
    let cell = 0.041;
    Net {
        low: DVec3::new(-18.0 * cell, -0.06, -0.24),
        high: DVec3::new(18.0 * cell, 1.86, 0.32),
        cell,
        smoothing_rounds: 3,
    }
}

/// Every bone as in the bind pose, but with hanging arms.
fn standing() -> Vec<DQuat> {
    let mut pose = vec![DQuat::IDENTITY; BONE_COUNT];
    for side in [LEFT, RIGHT] {
        set_arm(&mut pose, side, 3.0, -14.0);
    }
    pose
}

/// Turns an arm so that it hangs from the chest, swung back by `swing` degrees, its elbow bent by `bend` degrees.
fn set_arm(pose: &mut [DQuat], side: Side, swing: f64, bend: f64) {
    let drop = about_z(-side.sign * ARM_DROP_DEG);
    pose[side.shoulder] = pose[CHEST];
    pose[side.upper_arm] = pose[CHEST] * about_x(swing) * drop;
    pose[side.forearm] = pose[CHEST] * about_x(swing + bend) * drop;
    pose[side.hand] = pose[CHEST] * about_x(swing + bend * 1.2) * drop;
}

/// Key times, positions of the hips, and poses `[key][bone]`, of one walking cycle of a second that ends as it begins.
fn walk(bones: &[Bone]) -> (Vec<f64>, Vec<DVec3>, Vec<Vec<DQuat>>) {
    let (mut times, mut hips, mut poses) = (Vec::new(), Vec::new(), Vec::new());
    for key in 0..=WALK_KEYS {
        let phase = f64::from(key) / f64::from(WALK_KEYS);
        let (place, pose) = walk_pose(bones, phase);
        times.push(phase);
        hips.push(place);
        poses.push(pose);
    }
    (times, hips, poses)
}

fn walk_pose(bones: &[Bone], phase: f64) -> (DVec3, Vec<DQuat>) {
    let mut pose = vec![DQuat::IDENTITY; BONE_COUNT];
    let (forth, sideways) = (cos_turn(phase), sin_turn(phase - 0.05));
    let hips = DVec3::new(
        0.018 * sideways,
        bones[HIPS].joint.y - 0.027 - 0.014 * cos_turn(2.0 * (phase - 0.05)),
        0.0,
    );
    pose[HIPS] = about_y(-7.0 * forth) * about_z(2.5 * sideways) * about_x(3.0);
    pose[SPINE] = about_y(-forth) * about_x(4.0);
    pose[CHEST] = about_y(6.0 * forth) * about_z(-1.5 * sideways) * about_x(4.0);
    pose[NECK] = about_y(2.0 * forth) * about_x(2.0);
    pose[HEAD] = about_x(1.0 + 1.5 * cos_turn(2.0 * phase));
    for side in [LEFT, RIGHT] {
        let own_phase = if side.sign > 0.0 { phase } else { phase + 0.5 };
        let swing = 24.0 * cos_turn(own_phase) - 2.0;
        let bend = -28.0 + 14.0 * cos_turn(own_phase);
        set_arm(&mut pose, side, swing, bend);
        set_leg(&mut pose, bones, hips, side, own_phase);
    }
    (hips, pose)
}

/// Pitch of the foot in degrees over the cycle: lands on the heel, lies flat, rolls off over the toes.
const FOOT_PITCH_DEG: [(f64, f64); 7] = [
    (0.0, -16.0),
    (0.1, 0.0),
    (0.4, 0.0),
    (0.6, 42.0),
    (0.75, 22.0),
    (0.9, -12.0),
    (1.0, -16.0),
];

fn set_leg(pose: &mut [DQuat], bones: &[Bone], hips: DVec3, side: Side, phase: f64) {
    let stride = Stride {
        stance: 0.6,
        front: 0.23,
        back: 0.3,
        lift: 0.05,
    };
    let pitch = table(&FOOT_PITCH_DEG, phase);
    let foot = about_x(pitch);
    let rest_ankle = bones[side.foot].joint;
    // The foot turns about its ball when the heel is up, about the heel when the toes are.
    let pivot = if pitch > 0.0 {
        bones[side.toe].joint
    } else {
        DVec3::new(rest_ankle.x, 0.0, -0.04)
    };
    let ankle = pivot + foot * (rest_ankle - pivot) + stride.offset(phase);
    let hip = hips + pose[HIPS] * (bones[side.thigh].joint - bones[HIPS].joint);
    let angles = reach(hip, ankle, [THIGH_LENGTH, SHIN_LENGTH], 1.0);
    pose[side.thigh] = angles.upper_rotation();
    pose[side.shin] = angles.lower_rotation();
    pose[side.foot] = foot;
    // On the ground the toes stay flat while the foot rolls over them.
    pose[side.toe] = about_x(table(
        &[(0.0, -16.0), (0.1, 0.0), (0.58, 0.0), (0.7, 22.0), (1.0, -16.0)],
        phase,
    ));
}

/// Key times and poses `[key][bone]`: the right arm goes up, waves, and comes down; the head follows.
fn wave() -> (Vec<f64>, Vec<Vec<DQuat>>) {
    // Per key: seconds, and the forearm's swing to the side in degrees while the arm is up.
    let keys = [
        (0.0, None),
        (0.5, Some(0.0)),
        (0.8, Some(28.0)),
        (1.1, Some(-24.0)),
        (1.4, Some(28.0)),
        (1.7, Some(-24.0)),
        (2.0, Some(10.0)),
        (2.6, None),
    ];
    keys.iter()
        .map(|&(time, swing)| (time, swing.map_or_else(standing, waving)))
        .unzip()
}

fn waving(swing: f64) -> Vec<DQuat> {
    let mut pose = vec![DQuat::IDENTITY; BONE_COUNT];
    let lean = about_z(4.0 + 0.05 * swing);
    pose[CHEST] = lean;
    pose[NECK] = about_z(1.0);
    pose[HEAD] = about_y(-14.0) * about_z(-7.0);
    set_arm(&mut pose, LEFT, 3.0, -14.0);
    pose[RIGHT.shoulder] = lean * about_z(-12.0);
    pose[RIGHT.upper_arm] = lean * about_z(-54.0 + 0.15 * swing);
    pose[RIGHT.forearm] = pose[RIGHT.upper_arm] * about_x(-10.0) * about_z(-68.0 + swing);
    pose[RIGHT.hand] = pose[RIGHT.forearm] * about_z(0.5 * swing);
    pose
}
