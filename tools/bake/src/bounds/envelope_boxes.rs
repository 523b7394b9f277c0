//! Fuzzy boxes by interval arithmetic over envelopes.

use super::{ClusterSpace, FuzzyBox, cluster_space::Envelope};
use restpose_formats::{Model, geom::Aabb, rows::BoneEnvelopeRow};
use std::collections::BTreeMap;

/// 2⁻⁴⁹: bounds the roundings in `f64` of a fuzzy position's interval, under 16 of 2⁻⁵³ per influence and morph, relative
/// to what enters it.
const BOX_ROUNDING: f64 = 1.0 / (1u64 << 49) as f64;

/// A bone envelope row in `f64`.
struct Form {
    center: [f64; 12],
    direction: [f64; 12],
    reach: [f64; 12],
}

impl Form {
    fn new(row: &BoneEnvelopeRow) -> Self {
        Self {
            center: row.center.map(f64::from),
            direction: row.direction.map(f64::from),
            reach: row.reach.map(f64::from),
        }
    }
}

impl ClusterSpace {
    /// Fuzzy boxes of triangles of the cluster, in order: each contains the fuzzy positions of its corners in every pose of
    /// every envelope.
    pub(crate) fn fuzzy_boxes(&self, model: &Model, triangles: &[u32]) -> Vec<Aabb> {
        let mut place_of_mover = vec![None; model.bones.len()];
        for (place, mover) in self.movers.iter().enumerate() {
            place_of_mover[mover.bone as usize] = Some(place);
        }
        let mut target_places = BTreeMap::new();
        for (place, row) in self.morphs.iter().enumerate() {
            target_places.insert(row.target, place);
        }
        let forms: Vec<Vec<Form>> = self
            .envelopes
            .iter()
            .map(|envelope| envelope.bones.iter().map(Form::new).collect())
            .collect();
        let mut boxes: BTreeMap<u32, (FuzzyBox, f64)> = BTreeMap::new();
        let mut box_of = |vertex: u32| {
            *boxes.entry(vertex).or_insert_with(|| {
                let mut bounds = FuzzyBox::EMPTY;
                let mut error = 0.0;
                for (envelope, forms) in self.envelopes.iter().zip(&forms) {
                    let found =
                        self.vertex_box(model, vertex as usize, &place_of_mover, &target_places, envelope, forms);
                    bounds = bounds.union(found.0);
                    error = f64::max(error, found.1);
                }
                (bounds, error)
            })
        };
        let of_triangle = |triangle: &u32| {
            let corners = model.triangles[*triangle as usize].corners.map(&mut box_of);
            let bounds = corners
                .iter()
                .fold(FuzzyBox::EMPTY, |bounds, corner| bounds.union(corner.0));
            bounds.rounded_outwards(corners.iter().fold(0.0, |error, corner| error.max(corner.1)))
        };
        triangles.iter().map(of_triangle).collect()
    }

    /// The box of a vertex's fuzzy positions in one envelope, and a bound of its rounding.
    ///
    /// With p within r of m by the morph weights, and motions `C + αU ± e`, the fuzzy position is within
    /// `|Σ w(U(m − k) + U_d)| + Σ w(e|m − k| + e_d) + |1 + Σ wC|·r + Σ w(|U| + e)·r` of `m + Σ w(C(m − k) + C_d)`. Without
    /// morphs that is the smallest such box: each number of the form occurs once per axis.
    fn vertex_box(
        &self,
        model: &Model,
        vertex: usize,
        place_of_mover: &[Option<usize>],
        target_places: &BTreeMap<u32, usize>,
        envelope: &Envelope,
        forms: &[Form],
    ) -> (FuzzyBox, f64) {
        let mut middle = model.vertices[vertex].position_rest.map(f64::from);
        let mut spread = [0.0; 3];
        // Magnitudes that entered the middle.
        let mut entered = middle.map(f64::abs);
        let influences = model.influences_of(vertex);
        let terms = 1 + influences.len() + model.morph_deltas_of(vertex).len();
        for delta in model.morph_deltas_of(vertex) {
            let interval = &envelope.morphs[target_places[&delta.target]];
            let (min, max) = (f64::from(interval.min), f64::from(interval.max));
            for k in 0..3 {
                let delta = f64::from(delta.delta[k]);
                middle[k] += 0.5 * (min + max) * delta;
                entered[k] += 0.5 * (min + max).abs() * delta.abs();
                spread[k] += 0.5 * (max - min) * delta.abs();
            }
        }
        let morphed = spread != [0.0; 3];
        let mut is_still = model.morph_deltas_of(vertex).is_empty();
        let mut center = middle;
        let mut line = [0.0; 3];
        let mut reach = [0.0; 3];
        let mut turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut size: f64 = entered.iter().chain(&spread).sum();
        for influence in influences {
            let Some(place) = place_of_mover[influence.bone as usize] else {
                continue;
            };
            is_still = false;
            let (form, weight) = (&forms[place], f64::from(influence.weight));
            let pivot = self.movers[place].lever.pivot.map(f64::from);
            let arm: [f64; 3] = std::array::from_fn(|j| middle[j] - pivot[j]);
            let long_arm: [f64; 3] = std::array::from_fn(|j| entered[j] + pivot[j].abs());
            for k in 0..3 {
                let along = |numbers: &[f64; 12]| {
                    numbers[k] * arm[0] + numbers[3 + k] * arm[1] + numbers[6 + k] * arm[2] + numbers[9 + k]
                };
                let around = |numbers: &[f64; 12], arm: &[f64; 3]| {
                    let linear = (0..3).map(|j| numbers[3 * j + k].abs() * arm[j].abs()).sum::<f64>();
                    linear + numbers[9 + k].abs()
                };
                center[k] += weight * along(&form.center);
                line[k] += weight * along(&form.direction);
                reach[k] += weight * around(&form.reach, &arm);
                let forms = [&form.center, &form.direction, &form.reach];
                size += weight * forms.map(|form| around(form, &long_arm)).iter().sum::<f64>();
                if morphed {
                    for j in 0..3 {
                        let n = 3 * j + k;
                        turned[j][k] += weight * form.center[n];
                        reach[k] += weight * (form.direction[n].abs() + form.reach[n]) * spread[j];
                        size += weight * (form.center[n].abs() + form.direction[n].abs() + form.reach[n]) * spread[j];
                    }
                }
            }
        }
        let mut bounds = FuzzyBox::EMPTY;
        let half: [f64; 3] = std::array::from_fn(|k| {
            let morphs: f64 = (0..3).map(|j| turned[j][k].abs() * spread[j]).sum();
            line[k].abs() + reach[k] + morphs
        });
        bounds.add(std::array::from_fn(|k| center[k] - half[k]));
        bounds.add(std::array::from_fn(|k| center[k] + half[k]));
        (
            bounds,
            if is_still {
                0.0
            } else {
                BOX_ROUNDING * terms as f64 * size
            },
        )
    }
}
