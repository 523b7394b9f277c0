//! Weights of bones on vertices, and their storage as integers.

use crate::column::{Column, Component};
use crate::limbs::Body;
use glam::DVec3;

/// A bone of a figure in the pose in which its surface is built.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Name of its node.
    pub name: String,
    /// Parent bone, by number; always smaller than the bone's own.
    pub parent: Option<usize>,
    /// Position of the joint.
    pub joint: DVec3,
}

/// How many joints lie between two bones of a tree.
fn tree_distance(bones: &[Bone], mut a: usize, mut b: usize) -> usize {
    let mut steps = 0;
    while a != b {
        // Parents come first, so the larger number is never an ancestor of the smaller.
        let larger = if a > b { &mut a } else { &mut b };
        *larger = bones[*larger].parent.unwrap_or(0);
        steps += 1;
    }
    steps
}

/// Weights of a body's bones on a point, heaviest first, at most `limit`, not normalised.
///
/// A bone weighs by how much farther its limb is than the nearest one: nothing beyond `band`, scene units. Only the
/// nearest limb's bone, its neighbours, and bones two joints up or down from it take part, so that one leg does not
/// pull at the other.
pub fn influences(body: &Body, bones: &[Bone], point: DVec3, band: f64, limit: usize) -> Vec<(usize, f64)> {
    let mut nearest = vec![f64::INFINITY; bones.len()];
    for limb in &body.limbs {
        nearest[limb.bone] = nearest[limb.bone].min(limb.distance(point));
    }
    let (mut host, mut least) = (0, f64::INFINITY);
    for (bone, &distance) in nearest.iter().enumerate() {
        if distance < least {
            (host, least) = (bone, distance);
        }
    }
    let mut weights: Vec<(usize, f64)> = nearest
        .iter()
        .enumerate()
        .filter(|&(bone, _)| {
            tree_distance(bones, host, bone) < 2
                || tree_distance(bones, host, bone) == 2 && on_one_line(bones, host, bone)
        })
        .map(|(bone, &distance)| {
            let closeness = (1.0 - (distance - least) / band).max(0.0);
            (bone, closeness * closeness)
        })
        .filter(|&(_, weight)| weight > 0.0)
        .collect();
    weights.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    weights.truncate(limit);
    weights
}

/// Whether one bone is an ancestor of the other.
fn on_one_line(bones: &[Bone], a: usize, b: usize) -> bool {
    let mut upwards = Some(a.max(b));
    while let Some(bone) = upwards {
        if bone == a.min(b) {
            return true;
        }
        upwards = bones[bone].parent;
    }
    false
}

/// Weights as fractions of `whole` that sum to it exactly: each rounded down, the rest given to the largest remainders.
pub fn quantised(weights: &[f64], whole: u32) -> Vec<u32> {
    let sum: f64 = weights.iter().sum();
    let exact: Vec<f64> = weights.iter().map(|weight| weight / sum * f64::from(whole)).collect();
    let mut parts: Vec<u32> = exact.iter().map(|value| value.floor() as u32).collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|&a, &b| {
        let remainder = |index: usize| exact[index] - exact[index].floor();
        remainder(b).total_cmp(&remainder(a)).then(a.cmp(&b))
    });
    let missing = whole - parts.iter().sum::<u32>();
    for &index in order.iter().take(missing as usize) {
        parts[index] += 1;
    }
    parts
}

/// `JOINTS_0` and `WEIGHTS_0` of up to four influences per vertex, as bytes and as normalised integers of `component`.
pub fn four_influence_columns(influences: &[Vec<(usize, f64)>], component: Component) -> [Column; 2] {
    let whole = if component == Component::U8 { 255 } else { 65_535 };
    let mut joints = Vec::with_capacity(influences.len());
    let mut weights = Vec::with_capacity(influences.len());
    for influences in influences {
        let numbers: Vec<f64> = influences.iter().map(|&(_, weight)| weight).collect();
        let (mut joint_row, mut weight_row) = ([0; 4], [0; 4]);
        for (slot, part) in quantised(&numbers, whole).into_iter().enumerate().take(4) {
            weight_row[slot] = i64::from(part);
            // A joint without weight must be joint zero.
            if part > 0 {
                joint_row[slot] = influences[slot].0 as i64;
            }
        }
        joints.push(joint_row);
        weights.push(weight_row);
    }
    [
        Column::integers(Component::U8, false, &joints),
        Column::integers(component, true, &weights),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantised_weights_sum_to_the_whole() {
        assert_eq!(quantised(&[1.0, 1.0, 1.0], 255), [85, 85, 85]);
        assert_eq!(quantised(&[2.0, 2.0, 2.0, 2.0], 255), [64, 64, 64, 63]);
        assert_eq!(quantised(&[0.7, 0.2, 0.1], 65_535).iter().sum::<u32>(), 65_535);
    }

    #[test]
    fn tree_distance_counts_joints() {
        let bone = |parent| Bone {
            name: String::new(),
            parent,
            joint: DVec3::ZERO,
        };
        let bones = [bone(None), bone(Some(0)), bone(Some(1)), bone(Some(0))];
        assert_eq!(tree_distance(&bones, 2, 3), 3);
        assert_eq!(tree_distance(&bones, 1, 1), 0);
        assert!(on_one_line(&bones, 0, 2));
        assert!(!on_one_line(&bones, 1, 3));
    }
}
