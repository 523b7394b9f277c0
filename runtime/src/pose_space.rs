use restpose_formats::{
    ModelView,
    rows::{BoneEnvelopeRow, ClusterMorphRow, LeverRow, MorphEnvelopeRow},
};
use std::ops::Range;

/// Numbers of a cluster's relative motions by which its envelopes are told apart.
pub(crate) const MARKS: usize = 8;

/// What measuring poses against the pose spaces of an asset needs of its rows, made ready when it is opened.
#[derive(Debug, Default)]
pub(crate) struct PoseSpaces {
    movers: Vec<Mover>,
    /// Per cluster with a pose space, its range of `movers`.
    movers_of: Vec<Range<usize>>,
    /// Per cluster.
    marks: Vec<[Mark; MARKS]>,
    /// Per cluster, its first place in `outlines`.
    outline_first: Vec<usize>,
    /// Per cluster and envelope.
    outlines: Vec<Outline>,
}

/// A number of the relative motions of a cluster's bones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mark {
    /// Mover, counted in the cluster.
    pub mover: usize,
    /// Number of its motion, 0 to 11.
    pub number: usize,
}

/// An envelope by a few of its numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// One over the squared length of its line, in lengths, from the middle to an end; zero where it has none.
    pub per_length: f64,
    /// Per mark of the cluster, in lengths by which it displaces vertices.
    pub center: [f64; MARKS],
    /// No pose that it holds is farther from the center, per mark.
    pub radius: [f64; MARKS],
}

/// A bone that moves vertices of a cluster beside the cluster's own.
#[derive(Clone, Debug)]
pub(crate) struct Mover {
    pub pivot: [f64; 3],
    /// Greatest weight.
    pub weight: f64,
    /// Length per unit of each number of its relative motion: by how much it displaces a vertex that no morph moves.
    pub levers: [f64; 12],
    /// Their squares, by which the envelopes' lines were laid.
    pub squares: [f64; 12],
    /// Length per unit by which errors of all entries of A − 1 displace a vertex, at most: the levers of one axis, and what
    /// the pivot adds to d.
    pub spread: f64,
}

/// One cluster's pose space.
#[derive(Clone, Copy)]
pub(crate) struct PoseSpace<'a> {
    pub movers: &'a [Mover],
    pub morphs: &'a [ClusterMorphRow],
    pub envelope_count: u32,
    /// Whether every pose of the file's clips lies in an envelope.
    pub clips_inside: bool,
    bone_envelopes: &'a [BoneEnvelopeRow],
    morph_envelopes: &'a [MorphEnvelopeRow],
    pub marks: &'a [Mark; MARKS],
    /// Per envelope.
    pub outlines: &'a [Outline],
}

/// One envelope of a cluster.
#[derive(Clone, Copy)]
pub(crate) struct Envelope<'a> {
    /// Per mover.
    pub bones: &'a [BoneEnvelopeRow],
    /// Per morph target of the cluster.
    pub morphs: &'a [MorphEnvelopeRow],
    /// As in [`Outline`].
    pub per_length: f64,
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
            out.movers.extend(others.map(|(_, lever)| Mover::new(lever)));
            out.movers_of.push(first..out.movers.len());
            let movers = &out.movers[first..];
            let rows = &model.bone_envelopes[space.bone_envelope_first as usize..];
            let envelopes: Vec<&[BoneEnvelopeRow]> = (0..space.envelope_count as usize)
                .map(|at| &rows[at * movers.len()..][..movers.len()])
                .collect();
            let marks = marks(movers, &envelopes);
            out.marks.push(marks);
            out.outline_first.push(out.outlines.len());
            out.outlines
                .extend(envelopes.iter().map(|rows| Outline::new(movers, &marks, rows)));
        }
        out
    }

    /// The pose space of a cluster row; `None` where its boxes hold in every pose, or claim nothing.
    #[inline]
    pub(crate) fn of<'a>(&'a self, model: &ModelView<'a>, cluster: usize) -> Option<PoseSpace<'a>> {
        let row = model.pose_spaces.get(cluster)?;
        let movers = &self.movers[self.movers_of[cluster].clone()];
        let envelopes = row.envelope_count as usize;
        let morphs = row.morph_count as usize;
        Some(PoseSpace {
            movers,
            morphs: &model.cluster_morphs[row.morph_first as usize..][..morphs],
            envelope_count: row.envelope_count,
            clips_inside: row.clips_inside != 0,
            bone_envelopes: &model.bone_envelopes[row.bone_envelope_first as usize..][..envelopes * movers.len()],
            morph_envelopes: &model.morph_envelopes[row.morph_envelope_first as usize..][..envelopes * morphs],
            marks: &self.marks[cluster],
            outlines: &self.outlines[self.outline_first[cluster]..][..envelopes],
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
            per_length: self.outlines[number].per_length,
        }
    }
}

/// The numbers whose centers lie farthest apart, in lengths.
fn marks(movers: &[Mover], envelopes: &[&[BoneEnvelopeRow]]) -> [Mark; MARKS] {
    let mut spreads = Vec::with_capacity(12 * movers.len());
    for (mover, moved) in movers.iter().enumerate() {
        for number in 0..12 {
            let centers = envelopes.iter().map(|rows| f64::from(rows[mover].center[number]));
            let (least, greatest) = centers.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), x| {
                (least.min(x), greatest.max(x))
            });
            spreads.push(((greatest - least) * moved.levers[number], Mark { mover, number }));
        }
    }
    spreads.sort_by(|a, b| b.0.total_cmp(&a.0));
    std::array::from_fn(|at| spreads.get(at).map_or(Mark::default(), |(_, mark)| *mark))
}

impl Outline {
    fn new(movers: &[Mover], marks: &[Mark; MARKS], rows: &[BoneEnvelopeRow]) -> Self {
        /// Covers the roundings of a place on the line in `f64`, with room to spare.
        const SLACK: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;
        let of = |mark: &Mark, of: fn(&BoneEnvelopeRow, usize) -> f64| {
            // Without movers there are no numbers.
            let row = rows.get(mark.mover).zip(movers.get(mark.mover));
            row.map_or(0.0, |(row, mover)| of(row, mark.number) * mover.levers[mark.number])
        };
        let square = |(mover, row): (&Mover, &BoneEnvelopeRow)| {
            (0..12)
                .map(|n| f64::from(row.direction[n]) * f64::from(row.direction[n]) * mover.squares[n])
                .sum::<f64>()
        };
        let length: f64 = movers.iter().zip(rows).map(square).sum();
        let center = marks.each_ref().map(|mark| of(mark, |row, n| f64::from(row.center[n])));
        let radius = marks.each_ref().map(|mark| {
            let size = of(mark, |row, n| f64::from(row.center[n].abs()));
            let radius = of(mark, |row, n| {
                f64::from(row.direction[n].abs()) + f64::from(row.reach[n])
            });
            radius * SLACK + size * (SLACK - 1.0)
        });
        Self {
            // Without a line every place on it is the same.
            per_length: Some(1.0 / length).filter(|x| x.is_finite()).unwrap_or(0.0),
            center,
            radius,
        }
    }
}

impl Mover {
    fn new(row: &LeverRow) -> Self {
        let weight = f64::from(row.weight);
        let levers: [f64; 12] = std::array::from_fn(|n| if n < 9 { f64::from(row.lever[n / 3]) } else { weight });
        let pivot = row.pivot.map(f64::from);
        Self {
            pivot,
            weight,
            levers,
            squares: levers.map(|lever| lever * lever),
            spread: levers[0] + levers[3] + levers[6] + weight * (pivot[0].abs() + pivot[1].abs() + pivot[2].abs()),
        }
    }
}
