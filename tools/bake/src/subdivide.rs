//! Midpoint subdivision: the same surface with four times the triangles, for measurements at several tessellations.

use crate::import::{Animation, Influence, Primitive, VertexCache};
use std::collections::BTreeMap;

/// Splits every triangle at its edges' midpoints into four, `times` times. Midpoints get the mean of their ends'
/// positions, in every frame of a vertex cache, weights and morph displacements.
///
/// Vertices are then numbered as the triangles first use them, as exporters do: midpoints behind all else would lie far apart
/// in memory, where one triangle's vertices are each to be fetched for themselves.
#[must_use]
pub fn subdivide(animation: &Animation, times: u32) -> Animation {
    let mut out = animation.clone();
    for _ in 0..times {
        let mut points: Vec<NewPoints> = out.caches.iter().map(NewPoints::new).collect();
        for (index, mesh) in out.meshes.iter_mut().enumerate() {
            let mut parts = out.parts.iter().filter(|part| part.mesh == index);
            let cache = parts.find_map(|part| part.cache);
            for primitive in &mut mesh.primitives {
                split(primitive, cache.map(|cache| &mut points[cache]));
            }
        }
        for (cache, points) in out.caches.iter_mut().zip(&points) {
            points.append_to(cache);
        }
    }
    if times > 0 {
        let primitives = out.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives);
        primitives.for_each(number_by_use);
    }
    out
}

/// Numbers vertices in the order in which triangles use them; those that none uses come last.
fn number_by_use(primitive: &mut Primitive) {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; primitive.positions.len()];
    let mut order = Vec::with_capacity(numbers.len());
    let all = 0..numbers.len() as u32;
    for vertex in primitive.triangles.iter().flatten().copied().chain(all) {
        let number = &mut numbers[vertex as usize];
        if *number == UNUSED {
            *number = order.len() as u32;
            order.push(vertex as usize);
        }
    }
    for corner in primitive.triangles.iter_mut().flatten() {
        *corner = numbers[*corner as usize];
    }
    primitive.positions = picked(&primitive.positions, &order);
    for target in &mut primitive.morph_targets {
        *target = picked(target, &order);
    }
    if !primitive.points.is_empty() {
        primitive.points = picked(&primitive.points, &order);
    }
    if !primitive.influences.is_empty() {
        primitive.influences = picked(&primitive.influences, &order);
    }
}

fn picked<T: Clone>(from: &[T], order: &[usize]) -> Vec<T> {
    order.iter().map(|place| from[*place].clone()).collect()
}

/// Midpoints that a cache gets; primitives that share points share these too, so that no crack opens between them.
struct NewPoints {
    first: usize,
    ends: Vec<(u32, u32)>,
    places: BTreeMap<(u32, u32), u32>,
}

impl NewPoints {
    fn new(cache: &VertexCache) -> Self {
        Self {
            first: cache.point_count,
            ends: Vec::new(),
            places: BTreeMap::new(),
        }
    }

    fn between(&mut self, a: u32, b: u32) -> u32 {
        let ends = (a.min(b), a.max(b));
        *self.places.entry(ends).or_insert_with(|| {
            self.ends.push(ends);
            (self.first + self.ends.len() - 1) as u32
        })
    }

    fn append_to(&self, cache: &mut VertexCache) {
        let count = cache.point_count + self.ends.len();
        let mut positions = Vec::with_capacity(count * cache.frame_count());
        for frame in 0..cache.frame_count() {
            let points = cache.frame(frame);
            positions.extend_from_slice(points);
            positions.extend(self.ends.iter().map(|(a, b)| mean(points, *a, *b)));
        }
        cache.positions = positions;
        cache.point_count = count;
    }
}

fn mean(points: &[[f32; 3]], a: u32, b: u32) -> [f32; 3] {
    let (a, b) = (points[a as usize], points[b as usize]);
    std::array::from_fn(|k| 0.5 * a[k] + 0.5 * b[k])
}

fn split(primitive: &mut Primitive, mut points: Option<&mut NewPoints>) {
    let mut midpoints = BTreeMap::new();
    let mut triangles = Vec::with_capacity(primitive.triangles.len() * 4);
    for [a, b, c] in std::mem::take(&mut primitive.triangles) {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            *midpoints
                .entry((from.min(to), from.max(to)))
                .or_insert_with_key(|ends| add_midpoint(primitive, points.as_deref_mut(), *ends))
        });
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    primitive.triangles = triangles;
}

fn add_midpoint(primitive: &mut Primitive, points: Option<&mut NewPoints>, (a, b): (u32, u32)) -> u32 {
    let position = mean(&primitive.positions, a, b);
    primitive.positions.push(position);
    for target in &mut primitive.morph_targets {
        let delta = mean(target, a, b);
        target.push(delta);
    }
    let (a, b) = (a as usize, b as usize);
    if let (Some(points), false) = (points, primitive.points.is_empty()) {
        let point = points.between(primitive.points[a], primitive.points[b]);
        primitive.points.push(point);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{Local, Mesh, Node, Part};

    /// Two primitives that share the edge from point 0 to point 1, one frame after the other.
    fn two_triangles() -> Animation {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0]];
        let later = points.map(|[x, y, z]| [3.0 * x, y, z + 1.0]);
        let primitive = |corners: [u32; 3]| Primitive {
            positions: corners.map(|point| points[point as usize]).to_vec(),
            triangles: vec![[0, 1, 2]],
            points: corners.to_vec(),
            ..Primitive::default()
        };
        Animation {
            nodes: vec![Node {
                name: String::new(),
                parent: None,
                local: Local::Trs {
                    translation: [0.0; 3],
                    rotation: [0.0, 0.0, 0.0, 1.0],
                    scale: [1.0; 3],
                },
                weights: Vec::new(),
            }],
            meshes: vec![Mesh {
                primitives: vec![primitive([0, 1, 2]), primitive([1, 0, 3])],
                ..Mesh::default()
            }],
            parts: vec![Part {
                name: String::new(),
                node: 0,
                mesh: 0,
                skin: None,
                cache: Some(0),
            }],
            caches: vec![VertexCache {
                point_count: 4,
                positions: [points, later].concat(),
            }],
            ..Animation::default()
        }
    }

    #[test]
    fn midpoints_are_in_every_frame_and_shared_between_primitives() {
        let out = subdivide(&two_triangles(), 1);
        let cache = &out.caches[0];
        assert_eq!(
            (cache.point_count, cache.frame_count()),
            (9, 2),
            "five edges, one of them shared"
        );
        let [first, second] = [0, 1].map(|index: usize| &out.meshes[0].primitives[index]);
        let middle = |primitive: &Primitive| {
            let middle = primitive.positions.iter().position(|p| *p == [1.0, 0.0, 0.0]);
            primitive.points[middle.expect("the shared edge is split in both")]
        };
        assert_eq!(middle(first), middle(second));
        for primitive in [first, second] {
            assert_eq!(primitive.triangles.len(), 4);
            for (position, point) in primitive.positions.iter().zip(&primitive.points) {
                assert_eq!(*position, cache.frame(0)[*point as usize]);
            }
        }
        assert_eq!(cache.frame(1)[middle(first) as usize], [3.0, 0.0, 1.0]);
        assert_eq!(first.triangles[0], [0, 1, 2], "numbered by use");
        assert_eq!(subdivide(&two_triangles(), 2).caches[0].point_count, 25);
    }
}
