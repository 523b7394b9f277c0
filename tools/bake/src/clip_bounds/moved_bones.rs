use crate::poses::{Span, number_error};
use restpose_formats::{
    Model,
    geom::round::UNIT_ROUNDOFF,
    rows::{NONE, TriangleRow},
};

/// A bone, and where what it moves lies in the rest pose.
pub(super) struct MovedBone {
    /// Node row; none of the root bone.
    pub node: Option<usize>,
    /// Node from rest space, columns.
    pub bind: [[f64; 3]; 4],
    rest: Interval3,
    /// Per morph target that displaces some of it, by how much.
    morphs: Vec<(usize, Interval3)>,
}

/// Least and greatest, per axis.
#[derive(Clone, Copy)]
pub(super) struct Interval3 {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Interval3 {
    fn add(&mut self, point: [f32; 3]) {
        for k in 0..3 {
            self.min[k] = self.min[k].min(f64::from(point[k]));
            self.max[k] = self.max[k].max(f64::from(point[k]));
        }
    }
}

/// What a bone moves in the poses of a span.
pub(super) struct Moved {
    /// Contains the rest positions as morphed.
    pub bounds: Interval3,
    /// Bounds the magnitudes that enter them: the rest position's and that of every displacement, added up.
    pub size: [f64; 3],
}

/// Displacements are added up in `f64`, of as many morph targets as a vertex has: fewer than 2²².
const SUM_ERROR: f64 = 1.0 / (1u64 << 30) as f64;

/// Twice the error of rounding to `f32` below its least normal number.
pub(super) const LEAST_STEP: f64 = f32::MIN_POSITIVE as f64 * (2.0 * UNIT_ROUNDOFF);

/// The bones that move vertices of triangles with area, ascending. Of assets without vertex caches.
pub(super) fn moved_bones(model: &Model) -> Vec<MovedBone> {
    let mut bones: Vec<Option<MovedBone>> = model.bones.iter().map(|_| None).collect();
    let mut met = vec![false; model.vertices.len()];
    for TriangleRow { corners: [a, b, c] } in &model.triangles {
        if a == b || b == c || c == a {
            continue;
        }
        for vertex in [a, b, c].map(|vertex| *vertex as usize) {
            if std::mem::replace(&mut met[vertex], true) {
                continue;
            }
            for influence in model.influences_of(vertex) {
                let bone = bones[influence.bone as usize].get_or_insert_with(|| {
                    let row = &model.bones[influence.bone as usize];
                    MovedBone {
                        node: (row.node != NONE).then_some(row.node as usize),
                        bind: row.inverse_bind().columns.map(|column| column.map(f64::from)),
                        rest: Interval3 {
                            min: [f64::INFINITY; 3],
                            max: [f64::NEG_INFINITY; 3],
                        },
                        morphs: Vec::new(),
                    }
                });
                bone.rest.add(model.vertices[vertex].position_rest);
                for delta in model.morph_deltas_of(vertex) {
                    bone.displacement(delta.target as usize).add(delta.delta);
                }
            }
        }
    }
    bones.into_iter().flatten().collect()
}

impl MovedBone {
    /// Displacements by a morph target; of vertices that it leaves alone, none.
    fn displacement(&mut self, target: usize) -> &mut Interval3 {
        let place = match self.morphs.binary_search_by_key(&target, |(target, _)| *target) {
            Ok(place) => place,
            Err(place) => {
                let still = Interval3 {
                    min: [0.0; 3],
                    max: [0.0; 3],
                };
                self.morphs.insert(place, (target, still));
                place
            }
        };
        &mut self.morphs[place].1
    }

    /// What it moves in the poses of a span.
    pub(super) fn moved(&self, span: &Span) -> Moved {
        let mut bounds = self.rest;
        let mut size: [f64; 3] = std::array::from_fn(|k| self.rest.min[k].abs().max(self.rest.max[k].abs()));
        for (target, by) in &self.morphs {
            let weight = &span.morph_weights[*target];
            let (least, greatest) = weight.range();
            // Rounding to `f32`, and the evaluator's own.
            let rounding = UNIT_ROUNDOFF * least.abs().max(greatest.abs()) + LEAST_STEP + 2.0 * number_error(weight);
            let (least, greatest) = (least - rounding, greatest + rounding);
            for k in 0..3 {
                let ends = [least, greatest].map(|weight| [weight * by.min[k], weight * by.max[k]]);
                let ends = ends.as_flattened();
                bounds.min[k] += ends.iter().copied().fold(0.0, f64::min);
                bounds.max[k] += ends.iter().copied().fold(0.0, f64::max);
                size[k] += ends.iter().fold(0.0, |most: f64, end| most.max(end.abs()));
            }
        }
        if !self.morphs.is_empty() {
            for k in 0..3 {
                let error = SUM_ERROR * size[k];
                bounds.min[k] -= error;
                bounds.max[k] += error;
                size[k] += error;
            }
        }
        Moved { bounds, size }
    }
}
