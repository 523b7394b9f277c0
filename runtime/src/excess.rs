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
//! two, too.
//!
//! Everything is computed in `f64`. What rounding adds, that of the inverse evaluated after the fact, is bounded
//! beside it ([`Motions::rounding`]) and always part of the excess.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.6, which wishes for boxes found analytically or by affine
//! arithmetic. Differs from §3.4.2, whose boxes hold for sampled poses only.

use crate::{
    pose_space::{Envelope, MARKS, Mover, PoseSpace},
    relative_motions::{ROUNDING, RelativeMotion, RelativeMotions},
    simd::four,
};
use restpose_formats::rows::{BoneEnvelopeRow, ClusterMorphRow};

/// Relative slack for the sum that is the excess itself: a few hundred roundings of 2⁻⁵³, and two of each lever.
const SUM_SLACK: f64 = 1.0 / (1u64 << 44) as f64;

/// Envelopes whose excess is measured where none holds the pose: those that are nearest by their marks. Any would do.
const NEAREST_TRIED: usize = 4;

/// Envelopes, nearest first, that a mix is sought with.
const NEAREST_MIXED: usize = 8;

/// How far a pose is from a cluster's pose space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Excess {
    /// Bounds by how much fuzzy positions leave the cluster's boxes, per local axis; not finite where nothing bounds it.
    pub local: [f64; 3],
    /// Whether the pose is outside of all envelopes by more than rounding.
    pub is_outside: bool,
}

impl Excess {
    /// The longest of its lengths.
    pub(crate) fn largest(&self) -> f64 {
        self.local.into_iter().fold(0.0, f64::max)
    }

    /// Of clusters whose boxes hold in every pose, and of those that claim none.
    pub(crate) const NONE: Self = Self {
        local: [0.0; 3],
        is_outside: false,
    };
}

/// A bone that moves against the cluster in this pose.
#[derive(Clone, Copy, Debug)]
struct Motion {
    /// E, columns first, then d.
    numbers: [f64; 12],
    /// Bounds the error of each entry of E.
    error: f64,
}

/// An envelope, judged by a few numbers.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// False where one of them is out of its reach.
    may_hold: bool,
    /// Squared distance of these numbers from its center, in lengths.
    square: f64,
    number: u32,
}

/// The relative motions of a cluster's bones in a pose, and what is known of their rounding. Scratch: keep one and reuse it.
#[derive(Debug, Default)]
pub(crate) struct Motions {
    pub(crate) relative: RelativeMotions,
    motions: Vec<Motion>,
    /// Bounds the rounding of all numbers times their levers, per local axis.
    rounding: f64,
    /// By how much morphs displace a vertex, at most, per axis.
    morphed: [f64; 3],
    /// The envelopes that are nearest, nearest first.
    order: Vec<Candidate>,
}

impl Motions {
    /// Measures a pose, whose [`Self::relative`] motions are up to date, against a cluster's pose space.
    ///
    /// `nearest` is an envelope to try first and becomes the one that is nearest; what it was changes nothing of the result.
    ///
    /// Complexity: twelve comparisons per bone where the first envelope holds the pose, else a distance per envelope.
    #[inline(always)]
    pub(crate) fn measure(&mut self, space: &PoseSpace, morph_weights: &[f32], nearest: &mut u32) -> Excess {
        self.update(space, morph_weights);
        let first = self.excess_of_here(space, &space.envelope(*nearest), morph_weights);
        let mut found = if total(&first) == 0.0 {
            first
        } else {
            self.nearest_envelope(space, morph_weights, nearest)
        };
        if self.is_outside(&found) && space.morphs.is_empty() && space.envelope_count > 1 {
            found = self.mixed_with_another(space, *nearest, found);
        }
        self.beyond(found)
    }

    /// The excess, rounding included.
    #[inline(always)]
    fn beyond(&self, found: [f64; 3]) -> Excess {
        Excess {
            local: found.map(|x| (x + self.rounding) * (1.0 + SUM_SLACK)),
            // A NaN is outside of everything.
            is_outside: self.is_outside(&found),
        }
    }

    /// The excess of a pose, whose [`Self::relative`] motions are up to date, that is known to lie in an envelope: what
    /// [`Self::measure`] would find.
    #[inline(always)]
    pub(crate) fn inside(&mut self, space: &PoseSpace, morph_weights: &[f32]) -> Excess {
        self.bound_rounding(space, morph_weights);
        self.beyond([0.0; 3])
    }

    fn is_outside(&self, excess: &[f64; 3]) -> bool {
        !excess.iter().all(|x| *x <= self.rounding)
    }

    #[inline(always)]
    fn update(&mut self, space: &PoseSpace, morph_weights: &[f32]) {
        self.bound_rounding(space, morph_weights);
        self.motions.clear();
        for (mover, relative) in space.movers.iter().zip(&self.relative.motions) {
            self.motions.push(Motion::new(relative, mover));
        }
    }

    #[inline(always)]
    fn bound_rounding(&mut self, space: &PoseSpace, morph_weights: &[f32]) {
        self.morphed = displacement(space.morphs, |_, target| {
            f64::from(morph_weights[target as usize].abs())
        });
        let morphed = self.morphed[0] + self.morphed[1] + self.morphed[2];
        self.rounding = 0.0;
        for (mover, relative) in space.movers.iter().zip(&self.relative.motions) {
            self.rounding +=
                relative.entry_error * (mover.spread + mover.weight * morphed) + relative.offset_error * mover.weight;
        }
    }

    /// By how much the pose leaves one envelope, per local axis.
    fn excess_of(&self, space: &PoseSpace, envelope: &Envelope, morph_weights: &[f32]) -> [f64; 3] {
        self.excess_of_here(space, envelope, morph_weights)
    }

    /// The same, compiled where it is called.
    #[inline(always)]
    fn excess_of_here(&self, space: &PoseSpace, envelope: &Envelope, morph_weights: &[f32]) -> [f64; 3] {
        let place = self.place_on_line(space, envelope);
        let mut lengths = [0.0; 12];
        for ((motion, row), mover) in self.motions.iter().zip(envelope.bones).zip(space.movers) {
            let off = off_line(motion, row, place);
            // Most poses are inside: one branch for twelve numbers.
            let mut inside = true;
            for off in off {
                inside &= off <= 0.0;
            }
            if !inside {
                self.add_lengths(&mut lengths, &off, mover);
            }
        }
        let mut out = per_axis(&lengths);
        if space.morphs.is_empty() {
            return out;
        }
        let morphed = displacement(space.morphs, |place, target| {
            let (weight, interval) = (f64::from(morph_weights[target as usize]), &envelope.morphs[place]);
            (f64::from(interval.min) - weight)
                .max(weight - f64::from(interval.max))
                .max(0.0)
        });
        for k in 0..3 {
            out[k] += morphed[k];
        }
        if morphed != [0.0; 3] {
            for ((motion, row), mover) in self.motions.iter().zip(envelope.bones).zip(space.movers) {
                let off = off_line(motion, row, place);
                for n in 0..9 {
                    out[n % 3] +=
                        mover.weight * (motion.numbers[n].abs() + motion.error + beyond(off[n])) * morphed[n / 3];
                }
            }
        }
        out
    }

    /// Adds by how much a bone's numbers that are out of reach by `off` displace vertices, by number.
    fn add_lengths(&self, lengths: &mut [f64; 12], off: &[f64; 12], mover: &Mover) {
        for n in 0..12 {
            let morphed = if n < 9 { mover.weight * self.morphed[n / 3] } else { 0.0 };
            lengths[n] += beyond(off[n]) * (mover.levers[n] + morphed);
        }
    }

    /// Where on the line of an envelope the pose's motions are nearest: α, weighed by levers. Any α in [−1, 1] gives a
    /// bound; this one is what the baker made the reach for.
    #[inline(always)]
    fn place_on_line(&self, space: &PoseSpace, envelope: &Envelope) -> f64 {
        let mut along = [0.0; 12];
        for ((motion, row), mover) in self.motions.iter().zip(envelope.bones).zip(space.movers) {
            for n in 0..12 {
                let direction = f64::from(row.direction[n]) * mover.squares[n];
                along[n] += direction * (motion.numbers[n] - f64::from(row.center[n]));
            }
        }
        let place = sum(&along) * envelope.per_length;
        if place.is_nan() { 0.0 } else { place.clamp(-1.0, 1.0) }
    }

    /// The excess over the envelopes that may hold the pose, and the few that are nearest; `nearest` becomes the one where the
    /// least was found.
    fn nearest_envelope(&mut self, space: &PoseSpace, morph_weights: &[f32], nearest: &mut u32) -> [f64; 3] {
        let marked: [f64; MARKS] = space.marks.map(|mark| {
            let motion = self.motions.get(mark.mover).zip(space.movers.get(mark.mover));
            motion.map_or(0.0, |(motion, mover)| {
                motion.numbers[mark.number] * mover.levers[mark.number]
            })
        });
        self.order.clear();
        self.order.extend((0..).zip(space.outlines).map(|(number, outline)| {
            let off: [f64; MARKS] = std::array::from_fn(|at| (marked[at] - outline.center[at]).abs());
            Candidate {
                may_hold: off.iter().zip(&outline.radius).all(|(off, radius)| off <= radius),
                square: off.iter().map(|off| off * off).sum(),
                number,
            }
        }));
        let nearer = |a: &Candidate, b: &Candidate| a.square.total_cmp(&b.square).then(a.number.cmp(&b.number));
        let held = self.order.iter().filter(|candidate| candidate.may_hold);
        let held: Option<u32> = held
            .map(|candidate| candidate.number)
            .find(|number| total(&self.excess_of(space, &space.envelope(*number), morph_weights)) == 0.0);
        if let Some(number) = held {
            *nearest = number;
            return [0.0; 3];
        }
        if self.order.len() > NEAREST_MIXED {
            self.order.select_nth_unstable_by(NEAREST_MIXED, nearer);
            self.order.truncate(NEAREST_MIXED);
        }
        self.order.sort_unstable_by(nearer);
        let mut best = [f64::INFINITY; 3];
        for candidate in self.order.iter().take(NEAREST_TRIED) {
            let number = candidate.number;
            let excess = self.excess_of(space, &space.envelope(number), morph_weights);
            if total(&excess) < total(&best) {
                (best, *nearest) = (excess, number);
            }
        }
        best
    }

    /// The excess over the mix of envelope `first` with the one towards which the straight way passes nearest, where that
    /// is less than `alone`.
    ///
    /// A third envelope was tried: on blends of two poses it takes another 0 to 10 % off the excess, where the second
    /// takes off 20 to 60 %, and costs half as much again.
    fn mixed_with_another(&self, space: &PoseSpace, first: u32, alone: [f64; 3]) -> [f64; 3] {
        let from = space.envelope(first);
        let from_place = self.place_on_line(space, &from);
        let mut way: Option<(f64, Envelope, f64, f64)> = None;
        let others = self.order.iter().filter(|other| other.number != first);
        for other in others {
            let to = space.envelope(other.number);
            let to_place = self.place_on_line(space, &to);
            let (mut along, mut length) = ([0.0; 12], [0.0; 12]);
            let bones = self.motions.iter().zip(from.bones).zip(to.bones).zip(space.movers);
            for (((motion, from), to), mover) in bones {
                for n in 0..12 {
                    let start = on_line(from, from_place, n);
                    let step = on_line(to, to_place, n) - start;
                    along[n] += mover.squares[n] * step * (motion.numbers[n] - start);
                    length[n] += mover.squares[n] * step * step;
                }
            }
            let (along, length) = (along.iter().sum::<f64>(), length.iter().sum::<f64>());
            let share = (along / length).min(1.0);
            // What that takes off the squared distance.
            let gain = share * (2.0 * along - share * length);
            if share > 0.0 && gain.is_finite() && way.is_none_or(|(most, ..)| gain > most) {
                way = Some((gain, to, to_place, share));
            }
        }
        let Some((_, to, to_place, share)) = way else {
            return alone;
        };
        let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
        let mut lengths = [0.0; 12];
        let bones = self.motions.iter().zip(from.bones).zip(to.bones).zip(space.movers);
        for (((motion, from), to), mover) in bones {
            let off = std::array::from_fn(|n| {
                let center = mix(on_line(from, from_place, n), on_line(to, to_place, n));
                // The lines' own numbers may be far greater than their mix.
                let rounding = ROUNDING * mix(magnitude(from, n), magnitude(to, n));
                let reach = mix(f64::from(from.reach[n]), f64::from(to.reach[n]));
                (motion.numbers[n] - center).abs() - (reach - rounding)
            });
            self.add_lengths(&mut lengths, &off, mover);
        }
        let mixed = per_axis(&lengths);
        if total(&mixed) < total(&alone) { mixed } else { alone }
    }
}

#[inline(always)]
fn on_line(row: &BoneEnvelopeRow, place: f64, n: usize) -> f64 {
    f64::from(row.center[n]) + place * f64::from(row.direction[n])
}

/// Bounds the numbers on the line.
#[inline(always)]
fn magnitude(row: &BoneEnvelopeRow, n: usize) -> f64 {
    f64::from(row.center[n].abs()) + f64::from(row.direction[n].abs())
}

/// By how much each number is out of reach of a place on the line of an envelope; not above zero where it is not.
#[inline(always)]
fn off_line(motion: &Motion, row: &BoneEnvelopeRow, place: f64) -> [f64; 12] {
    let mut out = [0.0; 12];
    for n in 0..12 {
        // The line's numbers may be far greater than the motion's, and so is their rounding.
        let reach = f64::from(row.reach[n]) - ROUNDING * magnitude(row, n);
        out[n] = (motion.numbers[n] - on_line(row, place, n)).abs() - reach;
    }
    out
}

/// By threes of fours, so that no number waits for eleven others.
#[inline(always)]
fn sum(numbers: &[f64; 12]) -> f64 {
    let n = |k: usize| numbers[k] + numbers[4 + k] + numbers[8 + k];
    (n(0) + n(2)) + (n(1) + n(3))
}

/// The part above zero; `max` would make nothing of a NaN.
#[inline(always)]
fn beyond(off: f64) -> f64 {
    if off <= 0.0 { 0.0 } else { off }
}

/// Lengths by number, summed over what displaces along the same axis.
#[inline(always)]
fn per_axis(lengths: &[f64; 12]) -> [f64; 3] {
    std::array::from_fn(|k| (lengths[k] + lengths[3 + k]) + (lengths[6 + k] + lengths[9 + k]))
}

#[inline(always)]
fn total(excess: &[f64; 3]) -> f64 {
    excess[0] + excess[1] + excess[2]
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

impl Motion {
    #[inline(always)]
    fn new(relative: &RelativeMotion, mover: &Mover) -> Self {
        let ([x, y, z], pivot) = (&relative.columns, &mover.pivot);
        let offset = &relative.offset;
        let d = four(|k| offset[k] + x[k] * pivot[0] + y[k] * pivot[1] + z[k] * pivot[2]);
        let numbers = [x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2], d[0], d[1], d[2]];
        Self {
            numbers,
            error: relative.entry_error,
        }
    }
}
