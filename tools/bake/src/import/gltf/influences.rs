use super::{
    accessor::{Accessors, Component, Numbers},
    meshes::{attribute_path, expect_count},
    schema::Whole,
};
use crate::import::{Fault, Influence, fault_list::FaultList};
use std::collections::{BTreeMap, BTreeSet};

/// A vertex's weights may miss the sum of one by this much without a warning: eight 8-bit weights, each rounded by half
/// a step of 1/255.
const WEIGHT_SUM_TOLERANCE: f64 = 8.0 * 0.5 / 255.0;

/// Reads `JOINTS_n` and `WEIGHTS_n` for every n. Per vertex: joints in rising order, each once, weights above zero.
///
/// Gives no vertices where the primitive has no joints, nothing where it has a fault.
pub(super) fn read(
    attributes: &BTreeMap<String, Whole>,
    accessors: &Accessors,
    vertex_count: usize,
    joint_count: usize,
    primitive: &str,
    faults: &mut FaultList,
) -> Option<Vec<Vec<Influence>>> {
    let numbers = set_numbers(attributes);
    if numbers.is_empty() {
        return Some(Vec::new());
    }
    let mut complete = true;
    let mut sets = Vec::new();
    for number in numbers {
        let set = read_set(attributes, accessors, vertex_count, number, primitive, faults);
        match faults.keep(set) {
            Some(set) => {
                complete &= check(&set, joint_count, primitive, faults);
                sets.push(set);
            }
            None => complete = false,
        }
    }
    if !complete {
        return None;
    }
    let at = attribute_path(primitive, "WEIGHTS_0");
    let per_vertex = sets
        .len()
        .saturating_mul(4 * size_of::<Influence>())
        .saturating_add(size_of::<Vec<Influence>>());
    faults.keep(accessors.charge(vertex_count, per_vertex, &at))?;
    let (mut worst, mut off): (f64, usize) = (1.0, 0);
    let mut out = Vec::with_capacity(vertex_count);
    for vertex in 0..vertex_count {
        let merged = merge(sets.iter().flat_map(|set| {
            let four = set
                .joints
                .get(vertex)
                .into_iter()
                .flatten()
                .zip(set.weights.get(vertex).into_iter().flatten());
            four.map(|(joint, weight)| Influence {
                joint: *joint as usize,
                weight: *weight,
            })
        }));
        let sum: f64 = merged.iter().map(|influence| f64::from(influence.weight)).sum();
        if merged.is_empty() {
            faults.error(
                at,
                format!("the weights of vertex {vertex} sum to zero; expected a positive sum, normally one"),
            );
            return None;
        }
        let miss = (sum - 1.0).abs();
        off += usize::from(miss > WEIGHT_SUM_TOLERANCE);
        if miss > (worst - 1.0).abs() {
            worst = sum;
        }
        out.push(merged);
    }
    if off > 0 {
        faults.warn(
            at,
            format!("weights should sum to one; those of {off} vertices do not, the worst to {worst}; they are scaled to one"),
        );
    }
    Some(out)
}

/// The numbers n of which `JOINTS_n` or `WEIGHTS_n` exists.
fn set_numbers(attributes: &BTreeMap<String, Whole>) -> BTreeSet<u32> {
    let number = |name: &String| {
        let digits = name.strip_prefix("JOINTS_").or_else(|| name.strip_prefix("WEIGHTS_"))?;
        // "+1" and "01" parse as numbers but name no set.
        digits.parse::<u32>().ok().filter(|number| number.to_string() == digits)
    };
    attributes.keys().filter_map(number).collect()
}

/// A decoded pair of `JOINTS_n` and `WEIGHTS_n`.
struct Set {
    number: u32,
    joints: Vec<[u32; 4]>,
    weights: Vec<[f32; 4]>,
}

fn read_set(
    attributes: &BTreeMap<String, Whole>,
    accessors: &Accessors,
    vertex_count: usize,
    number: u32,
    primitive: &str,
    faults: &mut FaultList,
) -> Result<Set, Fault> {
    let (joints, weights) = (&format!("JOINTS_{number}"), &format!("WEIGHTS_{number}"));
    let find = |name: &str, partner: &str| {
        attributes.get(name).copied().ok_or_else(|| {
            let at = attribute_path(primitive, partner);
            Fault::error(
                at,
                format!("{partner} has no {name} beside it; expected both or neither"),
            )
        })
    };
    let (joint_index, weight_index) = (find(joints, weights)?, find(weights, joints)?);
    let (joints_at, weights_at) = (attribute_path(primitive, joints), attribute_path(primitive, weights));
    expect_count(
        accessors.get(joint_index, &joints_at)?.count.0,
        vertex_count,
        &joints_at,
    )?;
    let weight_row = accessors.get(weight_index, &weights_at)?;
    expect_count(weight_row.count.0, vertex_count, &weights_at)?;
    if !weight_row.normalized && accessors.component(weight_index, &weights_at)? != Component::F32 {
        faults.warn(
            &weights_at,
            "integer weights should be marked as normalized; they are taken to be",
        );
    }
    let joint_rows = accessors.wholes::<4>(joint_index, &joints_at);
    let weight_rows = accessors.floats::<4>(weight_index, Numbers::Normalized, &weights_at);
    match (joint_rows, weight_rows) {
        (Ok(joints), Ok(weights)) => Ok(Set {
            number,
            joints,
            weights,
        }),
        (Err(first), Err(second)) => {
            faults.push(first);
            Err(second)
        }
        (Err(fault), _) | (_, Err(fault)) => Err(fault),
    }
}

/// Weights must not be negative; joints with a weight must exist. A joint without weight may be any number: exporters
/// leave rubbish there. The first of each kind is reported per set.
fn check(set: &Set, joint_count: usize, primitive: &str, faults: &mut FaultList) -> bool {
    let pairs = || {
        let vertices = set.joints.iter().zip(&set.weights).enumerate();
        vertices.flat_map(|(vertex, (joints, weights))| joints.iter().zip(weights).map(move |pair| (vertex, pair)))
    };
    let negative = pairs().find(|(_, (_, weight))| **weight < 0.0);
    if let Some((vertex, (_, weight))) = negative {
        let message = format!("vertex {vertex} has the weight {weight}; expected none below zero");
        faults.error(attribute_path(primitive, &format!("WEIGHTS_{}", set.number)), message);
    }
    let missing = pairs().find(|(_, (joint, weight))| **weight > 0.0 && **joint as usize >= joint_count);
    if let Some((vertex, (joint, _))) = missing {
        let message = format!("vertex {vertex} refers to joint {joint}; the skin over it has {joint_count} joints");
        faults.error(attribute_path(primitive, &format!("JOINTS_{}", set.number)), message);
    }
    negative.is_none() && missing.is_none()
}

/// Adds the weights of each joint and drops joints without any.
fn merge(influences: impl Iterator<Item = Influence>) -> Vec<Influence> {
    let mut sorted: Vec<Influence> = influences.filter(|influence| influence.weight > 0.0).collect();
    sorted.sort_by_key(|influence| influence.joint);
    let mut out: Vec<Influence> = Vec::with_capacity(sorted.len());
    for influence in sorted {
        match out.last_mut() {
            Some(last) if last.joint == influence.joint => last.weight += influence.weight,
            _ => out.push(influence),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_adds_the_weights_of_a_joint() {
        let list = [(4, 0.25), (1, 0.5), (4, 0.25), (9, 0.0)].map(|(joint, weight)| Influence { joint, weight });
        let merged = [(1, 0.5), (4, 0.5)].map(|(joint, weight)| Influence { joint, weight });
        assert_eq!(merge(list.into_iter()), merged);
    }

    #[test]
    fn only_proper_numbers_name_sets() {
        let names = [
            "JOINTS_0",
            "WEIGHTS_0",
            "WEIGHTS_10",
            "JOINTS_+3",
            "JOINTS_02",
            "JOINTS_x",
            "POSITION",
        ];
        let attributes = names.map(|name| (name.to_owned(), Whole(0))).into_iter().collect();
        assert_eq!(set_numbers(&attributes).into_iter().collect::<Vec<_>>(), [0, 10]);
    }
}
