//! The pose space of a cluster: its envelopes, and the fuzzy boxes that hold in all of them.

use super::{FuzzyBox, affine_fit::fit, pivot::pivot};
use crate::{
    BakeError,
    assemble::row_count,
    poses::{BoneSpans, Chord, SampledPose, Span, Way, about, in_palette},
};
use bytemuck::Zeroable;
use restpose_formats::{
    Model,
    geom::{
        Aabb,
        round::{f32_above, f32_below},
    },
    rows::{BoneEnvelopeRow, ClusterMorphRow, LeverRow, MorphEnvelopeRow, PoseSpaceRow},
};
use std::collections::BTreeMap;

/// The poses that boxes are made for.
pub(crate) struct Poses<'a> {
    /// What clips pass through, with the bones' sizes.
    pub spans: &'a [(BoneSpans, Span)],
    /// Samples of the clips, then random poses.
    pub sampled: &'a [SampledPose],
    /// How many of `sampled` are samples of clips, which `spans` cover.
    pub of_clips: usize,
}

/// A bone that moves vertices of a cluster, beside the cluster's own.
struct Mover {
    bone: u32,
    lever: LeverRow,
}

/// A stretch of poses as one cluster sees it.
struct Stretch {
    chord: Chord,
    /// Least and greatest weight of each of the cluster's morph targets.
    morphs: Vec<(f64, f64)>,
}

/// Rows of one envelope.
struct Envelope {
    bones: Vec<BoneEnvelopeRow>,
    morphs: Vec<MorphEnvelopeRow>,
}

pub(crate) struct ClusterSpace {
    bone: u32,
    movers: Vec<Mover>,
    morphs: Vec<ClusterMorphRow>,
    envelopes: Vec<Envelope>,
}

impl ClusterSpace {
    /// The pose space of the cluster of `bone` that holds `triangles`, in at most `most` envelopes.
    pub(crate) fn new(model: &Model, poses: &Poses, bone: u32, triangles: &[u32], most: usize) -> Self {
        let mut vertices: Vec<u32> = triangles
            .iter()
            .flat_map(|triangle| model.triangles[*triangle as usize].corners)
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        let movers = movers(model, poses, bone, &vertices);
        let mut out = Self {
            bone,
            movers,
            morphs: cluster_morphs(model, &vertices),
            envelopes: Vec::new(),
        };
        let levers = out.levers();
        let (of_clips, random) = (out.clip_stretches(model, poses), out.random_stretches(poses));
        // Random poses fill a volume, of which pieces would cover little: they are one envelope.
        let random: Vec<&Stretch> = random.iter().collect();
        // Where nothing moves against the cluster, every pose is in its one envelope.
        let most = if out.movers.is_empty() && out.morphs.is_empty() {
            1
        } else {
            most
        };
        let for_clips = most.saturating_sub(usize::from(!random.is_empty())).max(1);
        let mut groups = out.groups(&of_clips, &levers, for_clips);
        if most == 1 && !groups.is_empty() {
            groups[0].extend(random);
        } else if !random.is_empty() {
            groups.push(random);
        }
        out.envelopes = groups.iter().map(|group| out.envelope(group, &levers)).collect();
        if out.envelopes.is_empty() {
            // The cluster's frame has no inverse in any pose: its boxes are never used.
            let row = BoneEnvelopeRow {
                center: [0.0; 12],
                direction: [0.0; 12],
                reach: [0.0; 12],
            };
            out.envelopes.push(Envelope {
                bones: vec![row; out.movers.len()],
                morphs: vec![MorphEnvelopeRow { min: 0.0, max: 0.0 }; out.morphs.len()],
            });
        }
        out
    }

    /// Twelve lengths per mover, as the runtime weighs its numbers.
    fn levers(&self) -> Vec<f64> {
        let of = |mover: &Mover| -> [f64; 12] {
            std::array::from_fn(|n| match n / 3 {
                3 => f64::from(mover.lever.weight),
                j => f64::from(mover.lever.lever[j]),
            })
        };
        self.movers.iter().flat_map(of).collect()
    }

    fn clip_stretches(&self, model: &Model, poses: &Poses) -> Vec<Stretch> {
        let ways: Option<Vec<Way>> = self
            .movers
            .iter()
            .map(|mover| Way::new(model, self.bone as usize, mover.bone as usize))
            .collect();
        let Some(ways) = ways else {
            return Vec::new();
        };
        let stretch = |(bones, span): &(BoneSpans, Span)| {
            let mut chord = Chord::default();
            for (way, mover) in ways.iter().zip(&self.movers) {
                if !way.follow(span, bones, mover.lever.pivot, &mut chord) {
                    return None;
                }
            }
            let range = |row: &ClusterMorphRow| span.morph_weights[row.target as usize].range();
            Stretch::new(chord, self.morphs.iter().map(range).collect())
        };
        poses.spans.iter().filter_map(stretch).collect()
    }

    fn random_stretches(&self, poses: &Poses) -> Vec<Stretch> {
        let stretch = |pose: &SampledPose| {
            let inverse = pose.inverses[self.bone as usize].as_ref()?;
            let mut chord = Chord::default();
            for mover in &self.movers {
                let motion = in_palette(
                    inverse,
                    &pose.palette[self.bone as usize],
                    &pose.palette[mover.bone as usize],
                );
                chord.begin.extend(about(&motion, mover.lever.pivot));
            }
            chord.end.clone_from(&chord.begin);
            chord.stray.resize(chord.begin.len(), 0.0);
            let weight = |row: &ClusterMorphRow| f64::from(pose.morph_weights[row.target as usize]);
            Stretch::new(
                chord,
                self.morphs.iter().map(|row| (weight(row), weight(row))).collect(),
            )
        };
        poses.sampled[poses.of_clips..].iter().filter_map(stretch).collect()
    }

    /// Groups stretches that are near each other: centers are chosen one after the other, each the stretch that is
    /// farthest from all before it, then every stretch joins the nearest.
    ///
    /// Source: Gonzalez, *Clustering to Minimize the Maximum Intercluster Distance*, 1985: at most twice the least
    /// possible radius.
    fn groups<'a>(&self, stretches: &'a [Stretch], levers: &[f64], most: usize) -> Vec<Vec<&'a Stretch>> {
        let places: Vec<Vec<f64>> = stretches.iter().map(|stretch| self.place(stretch, levers)).collect();
        let Some(first) = places.first() else {
            return Vec::new();
        };
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let mut nearest: Vec<(f64, usize)> = places.iter().map(|place| (distance(place, first), 0)).collect();
        let mut count = 1;
        while count < most {
            let mut farthest = (0.0, 0);
            for (at, (distance, _)) in nearest.iter().enumerate() {
                if *distance > farthest.0 {
                    farthest = (*distance, at);
                }
            }
            if farthest.0 == 0.0 {
                break;
            }
            for (place, nearest) in places.iter().zip(&mut nearest) {
                let distance = distance(place, &places[farthest.1]);
                if distance < nearest.0 {
                    *nearest = (distance, count);
                }
            }
            count += 1;
        }
        let mut groups = vec![Vec::new(); count];
        for (stretch, (_, group)) in stretches.iter().zip(nearest) {
            groups[group].push(stretch);
        }
        groups
    }

    /// The middle of a stretch, in lengths by which it displaces vertices.
    fn place(&self, stretch: &Stretch, levers: &[f64]) -> Vec<f64> {
        let chord = &stretch.chord;
        let bones = (0..levers.len()).map(|n| 0.5 * (chord.begin[n] + chord.end[n]) * levers[n]);
        let morphs = self.morphs.iter().zip(&stretch.morphs).map(|(row, (min, max))| {
            let extent = row.extent.iter().map(|x| f64::from(x * x)).sum::<f64>().sqrt();
            0.5 * (min + max) * extent
        });
        bones.chain(morphs).collect()
    }

    fn envelope(&self, group: &[&Stretch], levers: &[f64]) -> Envelope {
        let chords: Vec<&Chord> = group.iter().map(|stretch| &stretch.chord).collect();
        let morphs = (0..self.morphs.len())
            .map(|k| {
                let weights = group.iter().map(|stretch| stretch.morphs[k]);
                let (min, max) = weights.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), (least, greatest)| {
                    (min.min(least), max.max(greatest))
                });
                MorphEnvelopeRow {
                    min: f32_below(min),
                    max: f32_above(max),
                }
            })
            .collect();
        Envelope {
            bones: fit(&chords, levers),
            morphs,
        }
    }

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
        for delta in model.morph_deltas_of(vertex) {
            let interval = &envelope.morphs[target_places[&delta.target]];
            let (min, max) = (f64::from(interval.min), f64::from(interval.max));
            for k in 0..3 {
                let delta = f64::from(delta.delta[k]);
                middle[k] += 0.5 * (min + max) * delta;
                spread[k] += 0.5 * (max - min) * delta.abs();
            }
        }
        let morphed = spread != [0.0; 3];
        let mut is_still = model.morph_deltas_of(vertex).is_empty();
        let mut center = middle;
        let mut line = [0.0; 3];
        let mut reach = [0.0; 3];
        let mut turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut size = middle.iter().fold(0.0, |size: f64, x| size.max(x.abs())) + spread[0] + spread[1] + spread[2];
        for influence in model.influences_of(vertex) {
            let Some(place) = place_of_mover[influence.bone as usize] else {
                continue;
            };
            is_still = false;
            let (form, weight) = (&forms[place], f64::from(influence.weight));
            let pivot = self.movers[place].lever.pivot.map(f64::from);
            let arm: [f64; 3] = std::array::from_fn(|j| middle[j] - pivot[j]);
            for k in 0..3 {
                let along = |numbers: &[f64; 12]| {
                    numbers[k] * arm[0] + numbers[3 + k] * arm[1] + numbers[6 + k] * arm[2] + numbers[9 + k]
                };
                let around = |numbers: &[f64; 12]| {
                    let linear = (0..3).map(|j| numbers[3 * j + k].abs() * arm[j].abs()).sum::<f64>();
                    linear + numbers[9 + k].abs()
                };
                center[k] += weight * along(&form.center);
                line[k] += weight * along(&form.direction);
                reach[k] += weight * around(&form.reach);
                size += weight * (around(&form.center) + around(&form.direction) + around(&form.reach));
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
        (bounds, if is_still { 0.0 } else { BOX_ROUNDING * size })
    }

    /// Adds the rows of the pose space of cluster row `cluster`.
    pub(crate) fn add_rows(&self, model: &mut Model, cluster: usize) -> Result<(), BakeError> {
        let cluster = model.clusters[cluster];
        model.pose_spaces.push(PoseSpaceRow {
            envelope_count: row_count("envelopes", self.envelopes.len())?,
            bone_envelope_first: row_count("bone envelopes", model.bone_envelopes.len())?,
            morph_first: row_count("cluster morphs", model.cluster_morphs.len())?,
            morph_count: row_count("cluster morphs", self.morphs.len())?,
            morph_envelope_first: row_count("morph envelopes", model.morph_envelopes.len())?,
            reserved: [0; 3],
        });
        let rows = &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
        let lever = |bone: u32| {
            self.movers
                .iter()
                .find(|mover| mover.bone == bone)
                .map(|mover| mover.lever)
        };
        model
            .levers
            .extend(rows.iter().map(|row| lever(row.bone).unwrap_or_else(LeverRow::zeroed)));
        model.cluster_morphs.extend_from_slice(&self.morphs);
        for envelope in &self.envelopes {
            model.bone_envelopes.extend_from_slice(&envelope.bones);
            model.morph_envelopes.extend_from_slice(&envelope.morphs);
        }
        row_count("bone envelopes", model.bone_envelopes.len())?;
        row_count("morph envelopes", model.morph_envelopes.len())?;
        Ok(())
    }
}

/// 2⁻⁴⁸: bounds the roundings of a fuzzy position's interval in `f64`, under 32 of 2⁻⁵³, relative to what enters it.
const BOX_ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

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

impl Stretch {
    /// `None` where numbers leave the range of `f32`: such poses are left to the runtime's margin.
    fn new(chord: Chord, morphs: Vec<(f64, f64)>) -> Option<Self> {
        const LIMIT: f64 = f32::MAX as f64 / 8.0;
        let numbers = chord.begin.iter().chain(&chord.end).chain(&chord.stray);
        let in_range = numbers
            .chain(morphs.iter().flat_map(|(min, max)| [min, max]))
            .all(|x| x.abs() < LIMIT);
        in_range.then_some(Self { chord, morphs })
    }
}

/// The bones beside the cluster's own that move its vertices, ascending, with pivots and levers.
fn movers(model: &Model, poses: &Poses, bone: u32, vertices: &[u32]) -> Vec<Mover> {
    /// Sum of weights, weighed sum of positions.
    #[derive(Default)]
    struct Mass {
        weight: f64,
        moment: [f64; 3],
    }
    let mut masses: BTreeMap<u32, Mass> = BTreeMap::new();
    let influences = || {
        vertices.iter().flat_map(|vertex| {
            let position = model.vertices[*vertex as usize].position_rest.map(f64::from);
            let influences = model.influences_of(*vertex as usize).iter();
            influences
                .filter(|influence| influence.bone != bone)
                .map(move |influence| (position, influence))
        })
    };
    for (position, influence) in influences() {
        let mass = masses.entry(influence.bone).or_default();
        let weight = f64::from(influence.weight);
        mass.weight += weight;
        mass.moment = std::array::from_fn(|k| mass.moment[k] + weight * position[k]);
    }
    let mut levers: BTreeMap<u32, LeverRow> = masses
        .into_iter()
        .map(|(mover, mass)| {
            let center = mass.moment.map(|x| x / mass.weight);
            let own = influences().filter(|(_, influence)| influence.bone == mover);
            let spread = own.fold(0.0, |spread: f64, (position, _)| {
                (0..3).fold(spread, |spread, k| spread.max((position[k] - center[k]).abs()))
            });
            let row = LeverRow {
                pivot: pivot(poses.sampled, bone as usize, mover as usize, center, spread),
                lever: [0.0; 3],
                weight: 0.0,
                reserved: 0,
            };
            (mover, row)
        })
        .collect();
    for (position, influence) in influences() {
        if let Some(row) = levers.get_mut(&influence.bone) {
            row.weight = row.weight.max(influence.weight);
            for k in 0..3 {
                let lever = f64::from(influence.weight) * (position[k] - f64::from(row.pivot[k])).abs();
                row.lever[k] = row.lever[k].max(f32_above(lever));
            }
        }
    }
    levers.into_iter().map(|(bone, lever)| Mover { bone, lever }).collect()
}

/// The morph targets that displace these vertices, ascending, with the extent of their deltas.
fn cluster_morphs(model: &Model, vertices: &[u32]) -> Vec<ClusterMorphRow> {
    let mut rows: BTreeMap<u32, ClusterMorphRow> = BTreeMap::new();
    for delta in vertices
        .iter()
        .flat_map(|vertex| model.morph_deltas_of(*vertex as usize))
    {
        let row = rows.entry(delta.target).or_insert(ClusterMorphRow {
            target: delta.target,
            extent: [0.0; 3],
        });
        row.extent = std::array::from_fn(|k| row.extent[k].max(delta.delta[k].abs()));
    }
    rows.into_values().collect()
}
