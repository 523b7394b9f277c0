//! The four-legged creature of `mixed.glb`.

use crate::column::{Column, Component};
use crate::figure::{Skeleton, add_skinned_surface};
use crate::gait::{Stride, reach};
use crate::gltf_json::Node;
use crate::gltf_writer::{GltfWriter, Track};
use crate::limbs::{Body, Limb};
use crate::rotation::{about_x, about_y, cos_turn, sin_turn};
use crate::skinning::{Bone, influences};
use crate::surface_net::{Net, surface_of};
use glam::{DQuat, DVec3};

const PELVIS: usize = 0;
const SPINE: usize = 1;
const CHEST: usize = 2;
const NECK: usize = 3;
const HEAD: usize = 4;
const TAIL: [usize; 3] = [5, 6, 7];
const BONE_COUNT: usize = 20;
/// Seconds for one cycle of the gait.
const CYCLE: f64 = 1.0;
const KEYS: u32 = 12;

/// One of the four legs: three bones from `first` on.
struct Leg {
    name: &'static str,
    first: usize,
    /// Side: left is +x, for the creature looks along +z.
    sign: f64,
    hip: DVec3,
    parent: usize,
    knee_sign: f64,
    /// Phase of its step, turns.
    phase: f64,
}

const HIP_Y: f64 = 0.46;
const UPPER_LENGTH: f64 = 0.22;
const LOWER_LENGTH: f64 = 0.2;

fn legs() -> [Leg; 4] {
    let leg = |name, first, sign: f64, fore: bool, phase| Leg {
        name,
        first,
        sign,
        hip: DVec3::new(sign * 0.13, HIP_Y, if fore { 0.3 } else { -0.3 }),
        parent: if fore { CHEST } else { PELVIS },
        knee_sign: if fore { -1.0 } else { 1.0 },
        phase,
    };
    // A trot: the legs across from each other step together.
    [
        leg("fore_left", 8, 1.0, true, 0.0),
        leg("fore_right", 11, -1.0, true, 0.5),
        leg("hind_left", 14, 1.0, false, 0.5),
        leg("hind_right", 17, -1.0, false, 0.0),
    ]
}

/// Adds the creature under a placed armature node.
pub fn add_creature(writer: &mut GltfWriter, armature: Node, material: usize) -> Skeleton {
    let parent = writer.add_root(armature);
    let still = vec![DQuat::IDENTITY; BONE_COUNT];
    let skeleton = Skeleton::add(writer, parent, bones(), &still);
    let body = body(&skeleton.bones);
    let cell = 0.0475;
    let net = Net {
        low: DVec3::new(-8.0 * cell, -0.06, -1.05),
        high: DVec3::new(8.0 * cell, 1.05, 0.85),
        cell,
        smoothing_rounds: 3,
    };
    let surface = surface_of(&body, &net);
    let weights: Vec<_> = surface
        .positions
        .iter()
        .map(|&point| influences(&body, &skeleton.bones, point, 0.1, 4))
        .collect();
    let skin = skeleton.add_skin(writer, "creature_skin");
    add_skinned_surface(
        writer,
        "creature_body",
        &surface,
        Column::byte_normals(&surface.normals()),
        &weights,
        Component::U16,
        (skin, material),
    );
    skeleton
}

fn bones() -> Vec<Bone> {
    let bone = |name: &str, parent, joint: [f64; 3]| Bone {
        name: name.to_owned(),
        parent,
        joint: DVec3::from(joint),
    };
    let mut bones = vec![
        bone("pelvis", None, [0.0, 0.52, -0.28]),
        bone("spine", Some(PELVIS), [0.0, 0.53, -0.08]),
        bone("chest", Some(SPINE), [0.0, 0.54, 0.14]),
        bone("neck", Some(CHEST), [0.0, 0.6, 0.36]),
        bone("head", Some(NECK), [0.0, 0.78, 0.48]),
        bone("tail_0", Some(PELVIS), [0.0, 0.56, -0.42]),
        bone("tail_1", Some(TAIL[0]), [0.0, 0.64, -0.6]),
        bone("tail_2", Some(TAIL[1]), [0.0, 0.76, -0.76]),
    ];
    for leg in legs() {
        let below = |down: f64| (leg.hip - DVec3::Y * down).to_array();
        let named = |part: &str| format!("{part}_{}", leg.name);
        bones.extend([
            bone(&named("upper"), Some(leg.parent), below(0.0)),
            bone(&named("lower"), Some(leg.first), below(UPPER_LENGTH)),
            bone(&named("paw"), Some(leg.first + 1), below(UPPER_LENGTH + LOWER_LENGTH)),
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
    let joint = |bone: usize| bones[bone].joint.to_array();
    let mut limbs = vec![
        limb(PELVIS, [0.0, 0.53, -0.34], [0.0, 0.53, -0.2], 0.16, 0.165),
        limb(SPINE, [0.0, 0.53, -0.12], [0.0, 0.54, 0.06], 0.165, 0.175),
        limb(CHEST, [0.0, 0.54, 0.12], [0.0, 0.55, 0.3], 0.18, 0.165),
        limb(NECK, [0.0, 0.6, 0.36], [0.0, 0.76, 0.46], 0.115, 0.09),
        limb(HEAD, [0.0, 0.8, 0.46], [0.0, 0.79, 0.54], 0.115, 0.105),
        limb(HEAD, [0.0, 0.76, 0.58], [0.0, 0.745, 0.68], 0.075, 0.06),
        limb(HEAD, [0.07, 0.88, 0.44], [0.11, 0.98, 0.42], 0.042, 0.026),
        limb(HEAD, [-0.07, 0.88, 0.44], [-0.11, 0.98, 0.42], 0.042, 0.026),
        limb(TAIL[0], [0.0, 0.56, -0.42], joint(TAIL[1]), 0.07, 0.055),
        limb(TAIL[1], joint(TAIL[1]), joint(TAIL[2]), 0.055, 0.045),
        limb(TAIL[2], joint(TAIL[2]), [0.0, 0.9, -0.84], 0.045, 0.04),
    ];
    for leg in legs() {
        let [upper, lower, paw] = [0, 1, 2].map(|part| joint(leg.first + part));
        let x = leg.hip.x + leg.sign * 0.01;
        limbs.extend([
            limb(leg.first, upper, lower, 0.09, 0.062),
            limb(leg.first + 1, lower, paw, 0.06, 0.048),
            limb(
                leg.first + 2,
                [x, 0.045, leg.hip.z],
                [x, 0.042, leg.hip.z + 0.07],
                0.05,
                0.046,
            ),
        ]);
    }
    Body { limbs, blend: 0.06 }
}

/// The tracks of one cycle of its gait, on the spot, ending as it begins.
pub fn prowl(skeleton: &Skeleton) -> Vec<Track> {
    let (mut times, mut places, mut poses) = (Vec::new(), Vec::new(), Vec::new());
    for key in 0..=KEYS {
        let phase = f64::from(key) / f64::from(KEYS);
        let (place, pose) = prowl_pose(&skeleton.bones, phase);
        times.push(CYCLE * phase);
        places.push(place);
        poses.push(pose);
    }
    let mut tracks = skeleton.linear_tracks(&times, &poses);
    tracks.push(Track {
        node: skeleton.nodes[PELVIS],
        path: "translation",
        interpolation: "LINEAR",
        times,
        values: Column::vectors(&places),
    });
    tracks
}

fn prowl_pose(bones: &[Bone], phase: f64) -> (DVec3, Vec<DQuat>) {
    let mut pose = vec![DQuat::IDENTITY; BONE_COUNT];
    let (forth, sideways) = (cos_turn(phase), sin_turn(phase));
    let bob = 0.012 * cos_turn(2.0 * phase);
    let place = bones[PELVIS].joint - DVec3::Y * (0.045 + bob);
    pose[PELVIS] = about_y(5.0 * forth);
    pose[SPINE] = about_y(-forth);
    pose[CHEST] = about_y(-5.0 * forth);
    pose[NECK] = about_y(-forth) * about_x(3.0 + 2.0 * cos_turn(2.0 * phase));
    pose[HEAD] = about_y(5.0 * sideways) * about_x(4.0);
    for (number, bone) in TAIL.into_iter().enumerate() {
        let number = number as f64;
        let sweep = (12.0 + 10.0 * number) * sin_turn(phase - 0.12 * number);
        pose[bone] = about_y(sweep) * about_x(-6.0 * number);
    }

    // Where the joints of the trunk have come to.
    let step = |from: usize, to: usize| pose[from] * (bones[to].joint - bones[from].joint);
    let spine = place + step(PELVIS, SPINE);
    let chest = spine + step(SPINE, CHEST);
    for leg in legs() {
        let stride = Stride {
            stance: 0.55,
            front: 0.13,
            back: 0.15,
            lift: 0.09,
        };
        let base = if leg.parent == CHEST { chest } else { place };
        let hip = base + pose[leg.parent] * (leg.hip - bones[leg.parent].joint);
        let offset = stride.offset(phase + leg.phase);
        let ankle = bones[leg.first + 2].joint + offset;
        let angles = reach(hip, ankle, [UPPER_LENGTH, LOWER_LENGTH], leg.knee_sign);
        pose[leg.first] = angles.upper_rotation();
        pose[leg.first + 1] = angles.lower_rotation();
        // A lifted paw hangs.
        pose[leg.first + 2] = about_x(350.0 * offset.y);
    }
    (place, pose)
}
