//! By how much a pose leaves the pose space for which a cluster's fuzzy boxes hold.
//!
//! # Why no pose makes a hole
//!
//! Notation: `X` is the map of the cluster's own bone and `Xᵢ` that of another, both as stored (`f32`, without the
//! instance transform); `Rᵢ = X⁻¹·Xᵢ = (Aᵢ | bᵢ)`; a vertex at `p = rest + Σ mⱼ·δⱼ`, mⱼ the morph weights, has the fuzzy
//! position `q = Σ wᵢ·Rᵢ·p`. Weights sum to exactly one, so with any pivots kᵢ
//!
//! ```text
//! q = p + Σ wᵢ·(Eᵢ·(p − kᵢ) + dᵢ),   Eᵢ = Aᵢ − 1,   dᵢ = Eᵢ·kᵢ + bᵢ
//! ```
//!
//! which is linear in the twelve numbers (Eᵢ, dᵢ), the relative motion of bone i. An envelope of the cluster is a set of
//! relative motions of its bones and of morph weights for which the baker's boxes hold. Take the pose of the envelope
//! that is nearest, number by number: its numbers differ from the pose's by the *excess*, eᵢ ≥ 0 per number of a motion
//! and f ≥ 0 per weight. With x = Σ f·|δ|, the fuzzy position of the pose lies from that of the nearest one by at most
//!
//! ```text
//! Σ ( eᵢ·wᵢ|p − kᵢ| + wᵢ·e_dᵢ )  +  x + Σ wᵢ·(|Eᵢ| + eᵢ)·x
//! ```
//!
//! per local axis: the first sum moves the bones at the pose's own morph weights, the second the weights at the nearest
//! bones. `wᵢ|p − kᵢ|` and wᵢ are bounded by the levers of the file, and morphs come to `|p − kᵢ|` with the weights' own
//! magnitudes. So a box widened by this length holds for the pose; it joins the cluster's margin.
//!
//! Boxes are convex and q is linear in the motions, so boxes that hold for two envelopes hold for every mix of theirs at
//! the same morph weights. A pose between envelopes, as a blend of two clips is, is therefore measured against mixes of
//! them, too.
//!
//! Everything is computed in `f64`. What rounding adds, that of the inverse evaluated after the fact, is bounded
//! beside it ([`Motions::rounding`]) and always part of the excess.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.6, which wishes for boxes found analytically or by affine
//! arithmetic. Differs from §3.4.2, whose boxes hold for sampled poses only.

use restpose_formats::{
    ModelView,
    geom::Affine,
    rows::{BoneEnvelopeRow, ClusterMorphRow, ClusterRow, LeverRow, MorphEnvelopeRow, PoseSpaceRow},
};

/// 2⁻⁴⁸: bounds the `f64` roundings of a relative motion, under 32 of 2⁻⁵³, relative to the magnitudes that enter it.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// Relative slack for the sum that is the excess itself: a few hundred roundings of 2⁻⁵³.
const SUM_SLACK: f64 = 1.0 / (1u64 << 44) as f64;

/// Envelopes that a mix is made of, at most. On blends of two clips a second one takes off most of the excess.
const MOST_MIXED: usize = 3;

/// How far a pose is from a cluster's pose space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Excess {
    /// Bounds by how much fuzzy positions leave the cluster's boxes, per local axis; not finite where nothing bounds it.
    pub local: [f64; 3],
    /// Whether the pose is outside of all envelopes by more than rounding.
    pub is_outside: bool,
}

impl Excess {
    /// Of clusters whose boxes hold in every pose, and of those that claim none.
    pub(crate) const NONE: Self = Self {
        local: [0.0; 3],
        is_outside: false,
    };
}

/// The rows that describe one cluster's pose space.
#[derive(Clone, Copy)]
struct Space<'a> {
    row: &'a PoseSpaceRow,
    morphs: &'a [ClusterMorphRow],
    bone_envelopes: &'a [BoneEnvelopeRow],
    morph_envelopes: &'a [MorphEnvelopeRow],
}

/// A bone that moves against the cluster in this pose.
#[derive(Clone, Copy, Debug)]
struct Motion {
    /// E, columns first, then d.
    numbers: [f64; 12],
    /// Length per unit of each number: by how much it displaces a vertex, at most.
    levers: [f64; 12],
    /// Squares of the levers without morphs, as the baker weighed the numbers when it laid the envelopes' lines.
    weights: [f64; 12],
}

/// The relative motions of a cluster's bones in a pose, and what is known of their rounding. Scratch: keep one and reuse it.
#[derive(Debug, Default)]
pub(crate) struct Motions {
    motions: Vec<Motion>,
    /// Bounds the rounding of all numbers times their levers, per local axis.
    rounding: f64,
    mix: Vec<Mixed>,
}

/// Motions of one bone that a mix of envelopes is sure to hold: those within `reach` of `center`.
#[derive(Clone, Copy, Debug)]
struct Mixed {
    center: [f64; 12],
    /// Less what the center is rounded by; below zero where that is more.
    reach: [f64; 12],
}

/// Measures the pose against the pose space of cluster row `cluster`.
///
/// `inverse` is what [`invert_frame`](crate::invert_frame) made of the palette's map of the cluster's bone. `nearest`
/// is an envelope to try first and becomes the one that is nearest; what it was changes nothing of the result.
///
/// Complexity: as many comparisons as bones times twelve where the first envelope holds the pose, else times envelopes.
pub(crate) fn measure(
    model: &ModelView,
    cluster: usize,
    inverse: &[[f64; 3]; 3],
    palette: &[Affine],
    morph_weights: &[f32],
    nearest: &mut u32,
    motions: &mut Motions,
) -> Excess {
    let Some(row) = model.pose_spaces.get(cluster) else {
        return Excess::NONE;
    };
    let cluster = &model.clusters[cluster];
    let morphs = &model.cluster_morphs[row.morph_first as usize..][..row.morph_count as usize];
    motions.update(model, cluster, morphs, inverse, palette, morph_weights);
    let bones = motions.motions.len();
    let envelopes = row.envelope_count as usize;
    let space = Space {
        row,
        morphs,
        bone_envelopes: &model.bone_envelopes[row.bone_envelope_first as usize..][..envelopes * bones],
        morph_envelopes: &model.morph_envelopes[row.morph_envelope_first as usize..][..envelopes * morphs.len()],
    };
    let mut found = motions.nearest_envelope(&space, morph_weights, nearest);
    if motions.is_outside(&found) && morphs.is_empty() && envelopes > 1 {
        found = motions.mix_from(&space, *nearest as usize, found);
    }
    Excess {
        local: found.map(|x| (x + motions.rounding) * (1.0 + SUM_SLACK)),
        // A NaN is outside of everything.
        is_outside: motions.is_outside(&found),
    }
}

impl Space<'_> {
    fn bones_of(&self, envelope: usize, bones: usize) -> &[BoneEnvelopeRow] {
        &self.bone_envelopes[envelope * bones..][..bones]
    }

    fn morphs_of(&self, envelope: usize) -> &[MorphEnvelopeRow] {
        &self.morph_envelopes[envelope * self.morphs.len()..][..self.morphs.len()]
    }
}

/// `Σ` over a cluster's targets of `weight·extent`, per axis.
fn displacement(morphs: &[ClusterMorphRow], weight: impl Fn(usize, u32) -> f64) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (place, row) in morphs.iter().enumerate() {
        let weight = weight(place, row.target);
        for k in 0..3 {
            out[k] += weight * f64::from(row.extent[k]);
        }
    }
    out
}

fn total(excess: &[f64; 3]) -> f64 {
    excess[0] + excess[1] + excess[2]
}

impl Motions {
    fn is_outside(&self, excess: &[f64; 3]) -> bool {
        !excess.iter().all(|x| *x <= self.rounding)
    }

    fn update(
        &mut self,
        model: &ModelView,
        cluster: &ClusterRow,
        morphs: &[ClusterMorphRow],
        inverse: &[[f64; 3]; 3],
        palette: &[Affine],
        morph_weights: &[f32],
    ) {
        let own = &palette[cluster.bone as usize]
            .columns
            .map(|column| column.map(f64::from));
        let morphed = displacement(morphs, |_, target| f64::from(morph_weights[target as usize].abs()));
        let inverse_norm = norm(inverse.as_flattened());
        let slack = 2.0 * inverse_error(inverse, own) + ROUNDING;
        self.motions.clear();
        self.rounding = 0.0;
        let range =
            cluster.cluster_bone_first as usize..(cluster.cluster_bone_first + cluster.cluster_bone_count) as usize;
        for (row, lever) in model.cluster_bones[range.clone()].iter().zip(&model.levers[range]) {
            if row.bone == cluster.bone {
                continue;
            }
            let x = &palette[row.bone as usize].columns.map(|column| column.map(f64::from));
            let motion = Motion::new(inverse, own, x, lever, morphed);
            let linear = inverse_norm * norm(x[..3].as_flattened()) + 1.0;
            let offset = inverse_norm * (norm(&x[3]) + norm(&own[3]));
            let levers: f64 = (0..3).map(|j| motion.levers[3 * j]).sum();
            let pivot: f64 = lever.pivot.iter().map(|k| f64::from(k.abs())).sum();
            let weight = f64::from(lever.weight);
            self.rounding += slack * (linear * (levers + weight * pivot) + weight * offset);
            self.motions.push(motion);
        }
    }

    /// By how much the pose leaves one envelope, per local axis.
    fn excess_of(&self, space: &Space, envelope: usize, morph_weights: &[f32]) -> [f64; 3] {
        let mut out = [0.0; 3];
        let bones = space.bones_of(envelope, self.motions.len());
        let place = place_on_line(&self.motions, bones);
        let beyond = if space.morphs.is_empty() {
            [0.0; 3]
        } else {
            let intervals = space.morphs_of(envelope);
            displacement(space.morphs, |place, target| {
                let (weight, interval) = (f64::from(morph_weights[target as usize]), &intervals[place]);
                (f64::from(interval.min) - weight)
                    .max(weight - f64::from(interval.max))
                    .max(0.0)
            })
        };
        for k in 0..3 {
            out[k] = beyond[k];
        }
        let morphs = beyond != [0.0; 3];
        for (motion, row) in self.motions.iter().zip(bones) {
            let excess: [f64; 12] = std::array::from_fn(|n| {
                let nearest = f64::from(row.center[n]) + place * f64::from(row.direction[n]);
                ((motion.numbers[n] - nearest).abs() - f64::from(row.reach[n])).max(0.0)
            });
            add_lengths(&mut out, &excess, &motion.levers);
            if morphs {
                let weight = motion.levers[9];
                for j in 0..3 {
                    for k in 0..3 {
                        out[k] += weight * (motion.numbers[3 * j + k].abs() + excess[3 * j + k]) * beyond[j];
                    }
                }
            }
        }
        out
    }

    /// The least excess over all envelopes. `nearest` is tried first, and in the end is where it was found.
    fn nearest_envelope(&self, space: &Space, morph_weights: &[f32], nearest: &mut u32) -> [f64; 3] {
        let count = space.row.envelope_count;
        let first = if *nearest < count { *nearest } else { 0 };
        let mut best = (self.excess_of(space, first as usize, morph_weights), first);
        if total(&best.0) > 0.0 || best.0.iter().any(|x| x.is_nan()) {
            for envelope in 0..count {
                let excess = self.excess_of(space, envelope as usize, morph_weights);
                let (new, old) = (total(&excess), total(&best.0));
                // Of equals the lowest, whichever was tried first.
                if new < old || old.is_nan() || (new == old && envelope < best.1) {
                    best = (excess, envelope);
                }
                if new == 0.0 {
                    break;
                }
            }
        }
        *nearest = best.1;
        best.0
    }

    /// Moves from one envelope towards others for as long as that lessens the excess.
    fn mix_from(&mut self, space: &Space, envelope: usize, mut best: [f64; 3]) -> [f64; 3] {
        let bones = self.motions.len();
        self.mix.clear();
        let rows = space.bones_of(envelope, bones);
        let place = place_on_line(&self.motions, rows);
        self.mix.extend(rows.iter().map(|row| Mixed::on_line(row, place)));
        for _ in 1..MOST_MIXED {
            // The envelope towards which the straight way passes nearest, and how far to go.
            let mut way: Option<(f64, usize, f64)> = None;
            for other in 0..space.row.envelope_count as usize {
                let rows = space.bones_of(other, bones);
                let place = place_on_line(&self.motions, rows);
                let (mut along, mut length) = (0.0, 0.0);
                for ((motion, mixed), row) in self.motions.iter().zip(&self.mix).zip(rows) {
                    for n in 0..12 {
                        let to = f64::from(row.center[n]) + place * f64::from(row.direction[n]) - mixed.center[n];
                        along += motion.weights[n] * to * (motion.numbers[n] - mixed.center[n]);
                        length += motion.weights[n] * to * to;
                    }
                }
                let share = (along / length).min(1.0);
                // What that takes off the squared distance.
                let gain = share * (2.0 * along - share * length);
                if share > 0.0 && gain.is_finite() && way.is_none_or(|(most, ..)| gain > most) {
                    way = Some((gain, other, share));
                }
            }
            let Some((_, other, share)) = way else {
                return best;
            };
            let rows = space.bones_of(other, bones);
            let place = place_on_line(&self.motions, rows);
            let mut excess = [0.0; 3];
            for ((motion, mixed), row) in self.motions.iter().zip(&mut self.mix).zip(rows) {
                *mixed = mixed.towards(&Mixed::on_line(row, place), share);
                let beyond: [f64; 12] =
                    std::array::from_fn(|n| ((motion.numbers[n] - mixed.center[n]).abs() - mixed.reach[n]).max(0.0));
                add_lengths(&mut excess, &beyond, &motion.levers);
            }
            if !(total(&excess) < total(&best)) {
                return best;
            }
            best = excess;
            if total(&best) == 0.0 {
                return best;
            }
        }
        best
    }
}

/// Adds by how much an excess of a bone's numbers displaces vertices.
#[inline]
fn add_lengths(out: &mut [f64; 3], excess: &[f64; 12], levers: &[f64; 12]) {
    for k in 0..3 {
        for j in 0..4 {
            out[k] += excess[3 * j + k] * levers[3 * j + k];
        }
    }
}

/// Where on the line of an envelope the pose's motions are nearest: α, weighed by levers.
#[inline]
fn place_on_line(motions: &[Motion], rows: &[BoneEnvelopeRow]) -> f64 {
    let (mut along, mut length) = (0.0, 0.0);
    for (motion, row) in motions.iter().zip(rows) {
        for n in 0..12 {
            let direction = f64::from(row.direction[n]) * motion.weights[n];
            along += direction * (motion.numbers[n] - f64::from(row.center[n]));
            length += direction * f64::from(row.direction[n]);
        }
    }
    let place = along / length;
    // 0/0 where nothing moves; any place on the line is a right one.
    if place.is_nan() { 0.0 } else { place.clamp(-1.0, 1.0) }
}

impl Mixed {
    fn on_line(row: &BoneEnvelopeRow, place: f64) -> Self {
        let line = |n: usize| (f64::from(row.center[n]), place * f64::from(row.direction[n]));
        Self {
            center: std::array::from_fn(|n| line(n).0 + line(n).1),
            reach: std::array::from_fn(|n| f64::from(row.reach[n]) - ROUNDING * (line(n).0.abs() + line(n).1.abs())),
        }
    }

    fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
        Self {
            center: std::array::from_fn(|n| mix(self.center[n], other.center[n])),
            reach: std::array::from_fn(|n| {
                let rounding = ROUNDING * mix(self.center[n].abs(), other.center[n].abs());
                mix(self.reach[n], other.reach[n]) - rounding
            }),
        }
    }
}

impl Motion {
    fn new(
        inverse: &[[f64; 3]; 3],
        own: &[[f64; 3]; 4],
        x: &[[f64; 3]; 4],
        lever: &LeverRow,
        morphed: [f64; 3],
    ) -> Self {
        let turned = |v: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| inverse[k][0] * v[0] + inverse[k][1] * v[1] + inverse[k][2] * v[2])
        };
        let mut numbers = [0.0; 12];
        let mut offset = turned(std::array::from_fn(|k| x[3][k] - own[3][k]));
        for j in 0..3 {
            let column = turned(x[j]);
            for k in 0..3 {
                let entry = column[k] - if j == k { 1.0 } else { 0.0 };
                numbers[3 * j + k] = entry;
                offset[k] += entry * f64::from(lever.pivot[j]);
            }
        }
        numbers[9..].copy_from_slice(&offset);
        let weight = f64::from(lever.weight);
        let lever = |n: usize| if n < 9 { f64::from(lever.lever[n / 3]) } else { weight };
        Self {
            numbers,
            levers: std::array::from_fn(|n| lever(n) + if n < 9 { weight * morphed[n / 3] } else { 0.0 }),
            weights: std::array::from_fn(|n| lever(n) * lever(n)),
        }
    }
}

fn norm(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `‖L·X − I‖∞` for a computed inverse L, its own rounding included: `X⁻¹ − L = −(L·X − I)·X⁻¹`, so it bounds the
/// relative error of everything that L maps.
fn inverse_error(inverse: &[[f64; 3]; 3], own: &[[f64; 3]; 4]) -> f64 {
    inverse.iter().enumerate().fold(0.0, |worst, (k, row)| {
        let sum: f64 = (0..3)
            .map(|j| {
                let products: [f64; 3] = std::array::from_fn(|i| row[i] * own[j][i]);
                let identity = if j == k { 1.0 } else { 0.0 };
                let rounding = ROUNDING * (products.iter().map(|p| p.abs()).sum::<f64>() + identity);
                (products.iter().sum::<f64>() - identity).abs() + rounding
            })
            .sum();
        f64::max(worst, sum)
    })
}
