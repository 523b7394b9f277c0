//! The pose space of a cluster: its envelopes.

use super::{
    affine_fit::fit,
    movers::{Mover, cluster_morphs, movers},
    nearest_groups::nearest_groups,
};
use crate::{
    BakeError,
    assemble::row_count,
    poses::{BoneSpans, Chord, SampledPose, Span, Way, about, in_palette, number_error},
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

/// Poses that displace no vertex by more than this part of a triangle's size against each other need no envelopes of
/// their own: these would hardly make its box smaller.
const ENOUGH: f64 = 0.1;

/// The poses that boxes are made for.
pub(crate) struct Poses<'a> {
    /// What clips pass through, with the bones' sizes.
    pub spans: &'a [(BoneSpans, Span)],
    /// Samples of the clips, then random poses.
    pub sampled: &'a [SampledPose],
    /// How many of `sampled` are samples of clips, which `spans` cover.
    pub of_clips: usize,
    /// Whether `spans` cover all clips of the file at all times, and the pose without any.
    pub all_clips: bool,
}

/// A stretch of poses as one cluster sees it.
struct Stretch {
    chord: Chord,
    /// Least and greatest weight of each of the cluster's morph targets.
    morphs: Vec<(f64, f64)>,
}

/// Rows of one envelope.
pub(super) struct Envelope {
    pub bones: Vec<BoneEnvelopeRow>,
    pub morphs: Vec<MorphEnvelopeRow>,
}

pub(crate) struct ClusterSpace {
    bone: u32,
    pub(super) movers: Vec<Mover>,
    pub(super) morphs: Vec<ClusterMorphRow>,
    pub(super) envelopes: Vec<Envelope>,
    /// Whether these hold all poses of all clips.
    clips_inside: bool,
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
        let movers = movers(model, poses.sampled, bone, &vertices);
        let mut out = Self {
            bone,
            movers,
            morphs: cluster_morphs(model, &vertices),
            envelopes: Vec::new(),
            clips_inside: false,
        };
        let levers = out.levers();
        let (of_clips, random) = (out.clip_stretches(model, poses), out.random_stretches(poses));
        out.clips_inside = poses.all_clips && of_clips.len() == poses.spans.len();
        // Random poses fill a volume, of which pieces would cover little: they are one envelope.
        let random: Vec<&Stretch> = random.iter().collect();
        // Where nothing moves against the cluster, every pose is in its one envelope.
        let most = if out.movers.is_empty() && out.morphs.is_empty() {
            1
        } else {
            most
        };
        let for_clips = most.saturating_sub(usize::from(!random.is_empty())).max(1);
        let places: Vec<Vec<f64>> = of_clips.iter().map(|stretch| out.place(stretch, &levers)).collect();
        let mut groups: Vec<Vec<&Stretch>> =
            nearest_groups(&places, for_clips, ENOUGH * triangle_size(model, triangles))
                .into_iter()
                .map(|group| group.into_iter().map(|at| &of_clips[at]).collect())
                .collect();
        if most == 1 && !groups.is_empty() {
            groups[0].extend(random);
        } else if !random.is_empty() {
            groups.push(random);
        }
        out.envelopes = groups.iter().map(|group| out.envelope(group, &levers)).collect();
        if out.envelopes.is_empty() {
            // Nothing bounds any pose of the pose space: the runtime measures from bones that stand still.
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
            let range = |row: &ClusterMorphRow| {
                let weight = &span.morph_weights[row.target as usize];
                let ((least, greatest), error) = (weight.range(), 2.0 * number_error(weight));
                (least - error, greatest + error)
            };
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

    /// Adds the rows of the pose space of cluster row `cluster`.
    pub(crate) fn add_rows(&self, model: &mut Model, cluster: usize) -> Result<(), BakeError> {
        let cluster = model.clusters[cluster];
        model.pose_spaces.push(PoseSpaceRow {
            envelope_count: row_count("envelopes", self.envelopes.len())?,
            bone_envelope_first: row_count("bone envelopes", model.bone_envelopes.len())?,
            morph_first: row_count("cluster morphs", model.cluster_morphs.len())?,
            morph_count: row_count("cluster morphs", self.morphs.len())?,
            morph_envelope_first: row_count("morph envelopes", model.morph_envelopes.len())?,
            clips_inside: self.clips_inside.into(),
            reserved: [0; 2],
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

/// The mean side of the triangles' boxes in the rest pose.
fn triangle_size(model: &Model, triangles: &[u32]) -> f64 {
    let side = |triangle: &u32| {
        let corners = model.triangles[*triangle as usize].corners;
        let bounds = Aabb::around(corners.map(|corner| model.vertices[corner as usize].position_rest));
        (0..3)
            .map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]))
            .sum::<f64>()
            / 3.0
    };
    triangles.iter().map(side).sum::<f64>() / triangles.len().max(1) as f64
}
