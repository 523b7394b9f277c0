use restpose_formats::{
    ModelView,
    rows::{BoneEnvelopeRow, ClusterMorphRow, LeverRow, MorphEnvelopeRow},
};
use std::ops::Range;

/// What measuring poses against the pose spaces of an asset needs of its rows, made ready when it is opened.
#[derive(Debug, Default)]
pub(crate) struct PoseSpaces {
    movers: Vec<Mover>,
    /// Per cluster with a pose space, its range of `movers`.
    movers_of: Vec<Range<usize>>,
    /// Per cluster, its first place in `lines`.
    line_first: Vec<usize>,
    /// Per cluster and envelope.
    lines: Vec<Line>,
}

/// A bone that moves vertices of a cluster beside the cluster's own.
#[derive(Clone, Debug)]
pub(crate) struct Mover {
    /// Bone row.
    pub bone: usize,
    pub pivot: [f64; 3],
    /// Greatest weight.
    pub weight: f64,
    /// Length per unit of each number of its relative motion: by how much it displaces a vertex that no morph moves.
    pub levers: [f64; 12],
    /// Their squares, by which the envelopes' lines were laid.
    pub squares: [f64; 12],
}

/// The line of an envelope.
#[derive(Clone, Copy, Debug)]
struct Line {
    per_length: f64,
    square_radius: f64,
}

/// One cluster's pose space.
#[derive(Clone, Copy)]
pub(crate) struct PoseSpace<'a> {
    pub movers: &'a [Mover],
    pub morphs: &'a [ClusterMorphRow],
    pub envelope_count: u32,
    bone_envelopes: &'a [BoneEnvelopeRow],
    morph_envelopes: &'a [MorphEnvelopeRow],
    lines: &'a [Line],
}

/// One envelope of a cluster.
#[derive(Clone, Copy)]
pub(crate) struct Envelope<'a> {
    /// Per mover.
    pub bones: &'a [BoneEnvelopeRow],
    /// Per morph target of the cluster.
    pub morphs: &'a [MorphEnvelopeRow],
    /// One over the squared length of its line from the middle to an end, zero where it has none.
    pub per_length: f64,
    /// No pose that it holds is farther from its center, in lengths by which numbers displace vertices, squared.
    pub square_radius: f64,
}

impl PoseSpaces {
    /// Complexity: linear in the rows.
    pub(crate) fn new(model: &ModelView) -> Self {
        let mut out = Self::default();
        for (cluster, space) in model.clusters.iter().zip(model.pose_spaces) {
            let first = out.movers.len();
            let rows = cluster.cluster_bone_first as usize..;
            let rows = rows.start..rows.start + cluster.cluster_bone_count as usize;
            let rows = model.cluster_bones[rows.clone()].iter().zip(&model.levers[rows]);
            let others = rows.filter(|(row, _)| row.bone != cluster.bone);
            out.movers
                .extend(others.map(|(row, lever)| Mover::new(row.bone as usize, lever)));
            out.movers_of.push(first..out.movers.len());
            out.line_first.push(out.lines.len());
            let movers = &out.movers[first..];
            let rows = &model.bone_envelopes[space.bone_envelope_first as usize..];
            let rows = (0..space.envelope_count as usize).map(|at| &rows[at * movers.len()..][..movers.len()]);
            out.lines.extend(rows.map(|rows| Line::new(movers, rows)));
        }
        out
    }

    /// The pose space of a cluster row; `None` where its boxes hold in every pose, or claim nothing.
    pub(crate) fn of<'a>(&'a self, model: &ModelView<'a>, cluster: usize) -> Option<PoseSpace<'a>> {
        let row = model.pose_spaces.get(cluster)?;
        let movers = &self.movers[self.movers_of[cluster].clone()];
        let envelopes = row.envelope_count as usize;
        let morphs = row.morph_count as usize;
        Some(PoseSpace {
            movers,
            morphs: &model.cluster_morphs[row.morph_first as usize..][..morphs],
            envelope_count: row.envelope_count,
            bone_envelopes: &model.bone_envelopes[row.bone_envelope_first as usize..][..envelopes * movers.len()],
            morph_envelopes: &model.morph_envelopes[row.morph_envelope_first as usize..][..envelopes * morphs],
            lines: &self.lines[self.line_first[cluster]..][..envelopes],
        })
    }
}

impl<'a> PoseSpace<'a> {
    pub(crate) fn envelope(&self, number: u32) -> Envelope<'a> {
        let number = number as usize;
        let (bones, morphs) = (self.movers.len(), self.morphs.len());
        Envelope {
            bones: &self.bone_envelopes[number * bones..][..bones],
            morphs: &self.morph_envelopes[number * morphs..][..morphs],
            per_length: self.lines[number].per_length,
            square_radius: self.lines[number].square_radius,
        }
    }
}

impl Line {
    fn new(movers: &[Mover], rows: &[BoneEnvelopeRow]) -> Self {
        /// Covers the roundings of a distance in `f64`, with room to spare.
        const SLACK: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;
        let square = |of: fn(&BoneEnvelopeRow) -> &[f32; 12]| {
            let bones = movers.iter().zip(rows);
            let squares = bones.flat_map(|(mover, row)| {
                (0..12).map(move |n| f64::from(of(row)[n]) * f64::from(of(row)[n]) * mover.squares[n])
            });
            squares.sum::<f64>()
        };
        let (length, reach) = (square(|row| &row.direction), square(|row| &row.reach));
        let radius = length.sqrt() + reach.sqrt();
        Self {
            // Without a line every place on it is the same.
            per_length: Some(1.0 / length).filter(|x| x.is_finite()).unwrap_or(0.0),
            square_radius: radius * radius * SLACK,
        }
    }
}

impl Mover {
    fn new(bone: usize, row: &LeverRow) -> Self {
        let weight = f64::from(row.weight);
        let levers: [f64; 12] = std::array::from_fn(|n| if n < 9 { f64::from(row.lever[n / 3]) } else { weight });
        Self {
            bone,
            pivot: row.pivot.map(f64::from),
            weight,
            levers,
            squares: levers.map(|lever| lever * lever),
        }
    }
}
