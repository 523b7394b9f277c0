//! Midpoint subdivision: the same surface with four times the triangles, for measurements at several tessellations.

use crate::import::{Animation, Influence, Primitive};
use std::collections::BTreeMap;

/// Splits every triangle at its edges' midpoints into four, `times` times. Midpoints get the mean of their ends'
/// positions, weights and morph displacements.
#[must_use]
pub fn subdivide(animation: &Animation, times: u32) -> Animation {
    let mut out = animation.clone();
    for _ in 0..times {
        for primitive in out.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
            split(primitive);
        }
    }
    out
}

fn split(primitive: &mut Primitive) {
    let mut midpoints = BTreeMap::new();
    let mut triangles = Vec::with_capacity(primitive.triangles.len() * 4);
    for [a, b, c] in std::mem::take(&mut primitive.triangles) {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            *midpoints
                .entry((from.min(to), from.max(to)))
                .or_insert_with_key(|ends| add_midpoint(primitive, *ends))
        });
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    primitive.triangles = triangles;
}

fn add_midpoint(primitive: &mut Primitive, (a, b): (u32, u32)) -> u32 {
    let (a, b) = (a as usize, b as usize);
    let mean = |points: &[[f32; 3]]| -> [f32; 3] { std::array::from_fn(|k| 0.5 * points[a][k] + 0.5 * points[b][k]) };
    let position = mean(&primitive.positions);
    primitive.positions.push(position);
    for target in &mut primitive.morph_targets {
        let delta = mean(target);
        target.push(delta);
    }
    if !primitive.influences.is_empty() {
        let mut mixed: BTreeMap<usize, f64> = BTreeMap::new();
        for end in [a, b] {
            let sum: f64 = primitive.influences[end]
                .iter()
                .map(|influence| f64::from(influence.weight))
                .sum();
            for Influence { joint, weight } in &primitive.influences[end] {
                *mixed.entry(*joint).or_default() += 0.5 * f64::from(*weight) / sum;
            }
        }
        let influences = mixed.into_iter().map(|(joint, weight)| Influence {
            joint,
            weight: weight as f32,
        });
        primitive
            .influences
            .push(influences.filter(|influence| influence.weight > 0.0).collect());
    }
    (primitive.positions.len() - 1) as u32
}
