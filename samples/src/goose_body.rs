//! The goose of `goose.obj` as it stands before anything moves it: bones, flesh, surface.

use crate::limbs::{Body, Limb};
use crate::polygons::{Polygons, quadrilaterals};
use crate::skinning::{Bone, influences};
use crate::solids::sphere;
use crate::surface_net::{Net, surface_of};
use glam::DVec3;

/// Trunk; everything else hangs on it.
pub const TRUNK: usize = 0;
/// Three bones from the trunk up to the head.
pub const NECK: [usize; 3] = [1, 2, 3];
/// Head with its beak.
pub const HEAD: usize = 4;
/// Tail.
pub const TAIL: usize = 5;
/// Number of bones.
pub const BONE_COUNT: usize = 16;
/// Left, then right; the goose looks along +z, so left is +x.
pub const SIDES: [Side; 2] = [side(1.0, 6), side(-1.0, 11)];

/// Width of the zone in which a joint bends, scene units: wide, for there is more jelly than bone in it.
const BEND: f64 = 0.13;
/// Edge length of a cell of the surface net; the middle plane is a plane of the grid.
const CELL: f64 = 0.074;

/// The five bones of one side.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// 1 on the left, -1 on the right.
    pub sign: f64,
    /// Inner half of the wing.
    pub wing: usize,
    /// Outer half of the wing.
    pub wing_tip: usize,
    /// From hip to knee.
    pub thigh: usize,
    /// From knee to ankle.
    pub shank: usize,
    /// Foot.
    pub foot: usize,
}

const fn side(sign: f64, first: usize) -> Side {
    Side {
        sign,
        wing: first,
        wing_tip: first + 1,
        thigh: first + 2,
        shank: first + 3,
        foot: first + 4,
    }
}

/// The goose at rest.
#[derive(Clone, Debug)]
pub struct Goose {
    /// Bones, parents first; at rest none is turned.
    pub bones: Vec<Bone>,
    /// Points and faces; quadrilaterals but on the head and the eyes, which are triangles.
    pub mesh: Polygons,
    /// Per point, bones and weights that sum to one.
    pub weights: Vec<Vec<(usize, f64)>>,
    /// Per point, the unit direction in which jelly bulges.
    pub outward: Vec<DVec3>,
}

/// The goose, standing, wings spread, neck straight.
pub fn goose() -> Goose {
    let bones = bones();
    let body = body(&bones);
    let net = Net {
        low: DVec3::new(-14.0 * CELL, -0.1, -0.75),
        high: DVec3::new(14.0 * CELL, 1.6, 0.85),
        cell: CELL,
        smoothing_rounds: 3,
    };
    let surface = surface_of(&body, &net);
    let mut mesh = quadrilaterals(&surface, |point| point.y < 1.16);
    let mut outward: Vec<DVec3> = mesh.positions.iter().map(|point| body.outward(*point)).collect();
    let mut weights: Vec<_> = mesh
        .positions
        .iter()
        .map(|point| weigh(&body, &bones, *point))
        .collect();
    for side in SIDES {
        let middle = DVec3::new(side.sign * 0.095, 1.33, 0.41);
        let eye = sphere(1).map(|point| middle + point * 0.034);
        // An eye moves as one.
        outward.resize(outward.len() + eye.positions.len(), body.outward(middle));
        weights.resize(weights.len() + eye.positions.len(), vec![(HEAD, 1.0)]);
        mesh.append(&eye);
    }
    Goose {
        bones,
        mesh,
        weights,
        outward,
    }
}

fn weigh(body: &Body, bones: &[Bone], point: DVec3) -> Vec<(usize, f64)> {
    let mut weights = influences(body, bones, point, BEND, 4);
    let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
    for (_, weight) in &mut weights {
        *weight /= sum;
    }
    weights
}

fn bones() -> Vec<Bone> {
    let bone = |name: &str, parent, joint: [f64; 3]| Bone {
        name: name.to_owned(),
        parent,
        joint: DVec3::from(joint),
    };
    let mut bones = vec![
        bone("trunk", None, [0.0, 0.56, 0.0]),
        bone("neck_0", Some(TRUNK), [0.0, 0.74, 0.24]),
        bone("neck_1", Some(NECK[0]), [0.0, 0.91, 0.29]),
        bone("neck_2", Some(NECK[1]), [0.0, 1.08, 0.32]),
        bone("head", Some(NECK[2]), [0.0, 1.24, 0.34]),
        bone("tail", Some(TRUNK), [0.0, 0.62, -0.34]),
    ];
    for (side, suffix) in SIDES.into_iter().zip(["left", "right"]) {
        let at = |x: f64, y: f64, z: f64| [side.sign * x, y, z];
        let named = |part: &str| format!("{part}_{suffix}");
        bones.extend([
            bone(&named("wing"), Some(TRUNK), at(0.23, 0.68, 0.04)),
            bone(&named("wing_tip"), Some(side.wing), at(0.54, 0.71, -0.02)),
            bone(&named("thigh"), Some(TRUNK), at(0.16, 0.46, 0.0)),
            bone(&named("shank"), Some(side.thigh), at(0.16, 0.27, -0.06)),
            bone(&named("foot"), Some(side.shank), at(0.16, 0.09, 0.0)),
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
        limb(TRUNK, [0.0, 0.57, -0.16], [0.0, 0.6, 0.12], 0.24, 0.25),
        limb(NECK[0], joint(NECK[0]), joint(NECK[1]), 0.14, 0.105),
        limb(NECK[1], joint(NECK[1]), joint(NECK[2]), 0.105, 0.095),
        limb(NECK[2], joint(NECK[2]), joint(HEAD), 0.095, 0.095),
        limb(HEAD, [0.0, 1.3, 0.33], [0.0, 1.29, 0.39], 0.13, 0.12),
        limb(HEAD, [0.0, 1.26, 0.5], [0.0, 1.24, 0.64], 0.066, 0.056),
        limb(TAIL, [0.0, 0.62, -0.36], [0.0, 0.72, -0.56], 0.13, 0.06),
    ];
    for side in SIDES {
        let at = |x: f64, y: f64, z: f64| [side.sign * x, y, z];
        limbs.extend([
            limb(side.wing, at(0.22, 0.68, 0.05), at(0.54, 0.71, 0.02), 0.085, 0.072),
            limb(side.wing, at(0.22, 0.66, -0.1), at(0.54, 0.7, -0.12), 0.085, 0.068),
            limb(side.wing_tip, at(0.54, 0.71, 0.02), at(0.84, 0.73, -0.1), 0.076, 0.064),
            limb(side.wing_tip, at(0.54, 0.7, -0.12), at(0.76, 0.72, -0.16), 0.072, 0.06),
            limb(side.thigh, joint(side.thigh), joint(side.shank), 0.095, 0.075),
            limb(side.shank, joint(side.shank), joint(side.foot), 0.072, 0.064),
            limb(side.foot, at(0.16, 0.07, -0.03), at(0.17, 0.068, 0.17), 0.066, 0.064),
        ]);
    }
    Body { limbs, blend: 0.06 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_goose_is_closed_and_wholly_weighted() {
        let goose = goose();
        let surface = goose.mesh.triangulated();
        assert!(surface.is_closed_manifold());
        assert!(surface.volume() > 0.0);
        assert_eq!(goose.bones.len(), BONE_COUNT);
        for weights in &goose.weights {
            let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
            // Four roundings of parts of one.
            assert!((sum - 1.0).abs() < 1e-15, "{sum}");
        }
        for bone in 0..BONE_COUNT {
            let carried = goose.weights.iter().filter(|weights| weights[0].0 == bone).count();
            assert!(carried >= 8, "{} carries {carried} points", goose.bones[bone].name);
        }
        let corners = |count| goose.mesh.faces.iter().filter(|face| face.len() == count).count();
        assert!(corners(3) > 100 && corners(4) > 400, "{} {}", corners(3), corners(4));
    }
}
