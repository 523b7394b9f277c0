//! Decodes pose spaces as `FORMAT.md` describes them, in the manner of `bare_reader`, and holds the boxes and the margin
//! of the text against fuzzy positions.

use crate::{
    bare_boxes::planes,
    bare_reader::{f32s, rows, same, u32_at, u32s},
    fixture::model,
};

/// Some thirty operations on numbers below 8 are rounded, each by at most 2⁻⁵¹.
const ROUNDING: f64 = 32.0 / (1u64 << 51) as f64;

#[test]
fn rows_are_as_the_text_says() {
    let m = model();
    same!(b"PSPC", m.pose_spaces, b => u32s::<8>(b, 0), r => [
        r.envelope_count, r.bone_envelope_first, r.morph_first, r.morph_count, r.morph_envelope_first,
        r.clips_inside, r.reserved[0], r.reserved[1],
    ]);
    same!(b"LEVR", m.levers, b => (f32s::<3>(b, 0), f32s::<3>(b, 12), f32s::<1>(b, 24), u32_at(b, 28)), r => (
        r.pivot, r.lever, [r.weight], r.reserved,
    ));
    same!(b"CMOR", m.cluster_morphs, b => (u32_at(b, 0), f32s::<3>(b, 4)), r => (r.target, r.extent));
    same!(b"BENV", m.bone_envelopes, b => (f32s::<12>(b, 0), f32s::<12>(b, 48), f32s::<12>(b, 96)), r => (
        r.center, r.direction, r.reach,
    ));
    same!(b"MENV", m.morph_envelopes, b => f32s::<2>(b, 0), r => [r.min, r.max]);
}

/// A cluster of the arm, in which one bone beside its own moves vertices.
struct Cluster {
    at: usize,
    bytes: &'static [u8],
    space: &'static [u8],
    /// The other bone, and its row of LEVR.
    other: u32,
    lever: &'static [u8],
}

/// A pose, as far as the cluster's fuzzy positions depend on it.
#[derive(Clone)]
struct Pose {
    /// Relative motion of the other bone.
    motion: [f64; 12],
    /// Weight per row of CMOR of the cluster.
    weights: Vec<f64>,
}

impl Cluster {
    fn new(at: usize) -> Self {
        let bytes = rows(b"CLUS")[at];
        let listed = u32_at(bytes, 20)..u32_at(bytes, 20) + u32_at(bytes, 24);
        let bone_of = |row: u32| u32_at(rows(b"CBON")[row as usize], 0);
        let mut others = listed.filter(|row| bone_of(*row) != u32_at(bytes, 0));
        let row = others.next().expect("another bone");
        assert_eq!(others.next(), None, "one other bone");
        Self {
            at,
            bytes,
            space: rows(b"PSPC")[at],
            other: bone_of(row),
            lever: rows(b"LEVR")[row as usize],
        }
    }

    /// The rows of CMOR.
    fn morphs(&self) -> Vec<&'static [u8]> {
        let (first, count) = (u32_at(self.space, 8) as usize, u32_at(self.space, 12) as usize);
        rows(b"CMOR")[first..first + count].to_vec()
    }

    /// The poses of envelope `e` in which every number is at an end of its range, `excess` further out than the envelope
    /// says.
    fn corners(&self, e: usize, excess: f64) -> Vec<Pose> {
        let envelope = rows(b"BENV")[u32_at(self.space, 4) as usize + e];
        let [center, direction, reach] = [0, 48, 96].map(|at| f32s::<12>(envelope, at).map(f64::from));
        let morphs = self.morphs().len();
        let first = u32_at(self.space, 16) as usize + e * morphs;
        let intervals: Vec<[f32; 2]> = rows(b"MENV")[first..first + morphs]
            .iter()
            .map(|b| f32s(b, 0))
            .collect();
        let mut poses = Vec::new();
        // Numbers of one column move together: a fuzzy position's axis depends on one number of each.
        for (signs, alpha) in (0..16).flat_map(|signs| [-1.0, -0.5, 1.0].map(|alpha| (signs, alpha))) {
            let motion = std::array::from_fn(|i| {
                let sign = if signs >> (i / 3) & 1 == 1 { 1.0 } else { -1.0 };
                center[i] + alpha * direction[i] + sign * (reach[i] + excess)
            });
            for ends in 0..1 << morphs {
                let weights = intervals.iter().enumerate().map(|(t, [min, max])| match ends >> t & 1 {
                    0 => f64::from(*min) - excess,
                    _ => f64::from(*max) + excess,
                });
                let weights = weights.collect();
                poses.push(Pose { motion, weights });
            }
        }
        poses
    }

    /// The fuzzy position of a vertex in a pose.
    fn fuzzy(&self, vertex: usize, pose: &Pose) -> [f64; 3] {
        let row = rows(b"VERT")[vertex];
        let mut p = f32s::<3>(row, 0).map(f64::from);
        let ends = [vertex, vertex + 1].map(|row| u32_at(rows(b"MFST")[row], 0) as usize);
        for delta in &rows(b"MDEL")[ends[0]..ends[1]] {
            let morphs = self.morphs();
            let target = morphs.iter().position(|morph| u32_at(morph, 0) == u32_at(delta, 0));
            let weight = pose.weights[target.expect("the target is listed")];
            let delta = f32s::<3>(delta, 4);
            p = std::array::from_fn(|k| p[k] + weight * f64::from(delta[k]));
        }
        let pivot = f32s::<3>(self.lever, 0).map(f64::from);
        let weight = self.weight(vertex);
        std::array::from_fn(|r| {
            let turned: f64 = (0..3).map(|j| pose.motion[3 * j + r] * (p[j] - pivot[j])).sum();
            p[r] + weight * (turned + pose.motion[9 + r])
        })
    }

    /// The weight with which the other bone moves a vertex.
    fn weight(&self, vertex: usize) -> f64 {
        let ends = [vertex, vertex + 1].map(|row| u32_at(rows(b"VERT")[row], 12) as usize);
        let influences = &rows(b"INFL")[ends[0]..ends[1]];
        let weight = influences.iter().find(|influence| u32_at(influence, 0) == self.other);
        weight.map_or(0.0, |influence| f64::from(f32s::<1>(influence, 4)[0]))
    }

    /// The rows of REFS and RBOX, and the triangle's corners.
    fn references(&self) -> impl Iterator<Item = (usize, [usize; 3])> {
        let first = u32_at(self.bytes, 12);
        (first..first + u32_at(self.bytes, 16)).map(|row| {
            let triangle = rows(b"TRIS")[u32_at(rows(b"REFS")[row as usize], 0) as usize];
            (row as usize, u32s::<3>(triangle, 0).map(|corner| corner as usize))
        })
    }

    /// The margin of 6.7 for a pose that exceeds each range by `excess`.
    fn margin(&self, pose: &Pose, excess: f64) -> [f64; 3] {
        let lever = f32s::<3>(self.lever, 12).map(f64::from);
        let weight = f64::from(f32s::<1>(self.lever, 24)[0]);
        let (mut displaced, mut x) = ([0.0; 3], [0.0; 3]);
        for (morph, morph_weight) in self.morphs().iter().zip(&pose.weights) {
            let extent = f32s::<3>(morph, 4).map(f64::from);
            for j in 0..3 {
                displaced[j] += morph_weight.abs() * extent[j];
                x[j] += excess * extent[j];
            }
        }
        std::array::from_fn(|r| {
            let columns = (0..3).map(|j| {
                let motion = pose.motion[3 * j + r].abs();
                excess * (lever[j] + weight * displaced[j]) + weight * (motion + excess) * x[j]
            });
            columns.sum::<f64>() + weight * excess + x[r]
        })
    }
}

/// The clusters of the arm and the numbers of their envelopes.
fn envelopes() -> impl Iterator<Item = (Cluster, usize)> {
    let counts = [(1, 2), (2, 1)];
    counts.into_iter().flat_map(|(at, count)| {
        assert_eq!(u32_at(Cluster::new(at).space, 0), count);
        (0..count as usize).map(move |e| (Cluster::new(at), e))
    })
}

#[test]
fn boxes_hold_in_every_pose_of_an_envelope() {
    for (cluster, e) in envelopes() {
        for (row, corners) in cluster.references() {
            let [min, max] = planes(rows(b"RBOX")[row], cluster.bytes);
            for (vertex, pose) in corners
                .iter()
                .flat_map(|vertex| cluster.corners(e, 0.0).into_iter().map(move |pose| (*vertex, pose)))
            {
                let q = cluster.fuzzy(vertex, &pose);
                let inside = (0..3).all(|k| min[k] <= q[k] && q[k] <= max[k]);
                assert!(inside, "cluster {}, envelope {e}, vertex {vertex}: {q:?}", cluster.at);
            }
        }
    }
}

#[test]
fn the_margin_bounds_how_far_a_pose_outside_leaves_the_boxes() {
    // Of the margin, the largest part that was needed.
    let mut needed: f64 = 0.0;
    for (cluster, e) in envelopes() {
        for vertex in cluster.references().flat_map(|(_, corners)| corners) {
            let inside: Vec<_> = cluster
                .corners(e, 0.0)
                .iter()
                .map(|pose| cluster.fuzzy(vertex, pose))
                .collect();
            let end = |k: usize, pick: fn(f64, f64) -> f64| inside.iter().map(|q| q[k]).reduce(pick).expect("poses");
            for excess in [0.0, 2.0f64.powi(-20), 0.25, 1.0] {
                for pose in cluster.corners(e, excess) {
                    let (q, margin) = (cluster.fuzzy(vertex, &pose), cluster.margin(&pose, excess));
                    for k in 0..3 {
                        let beyond = (end(k, f64::min) - q[k]).max(q[k] - end(k, f64::max));
                        assert!(
                            beyond <= margin[k] + ROUNDING,
                            "cluster {}, envelope {e}, vertex {vertex}, axis {k}: {beyond} beyond, {margin:?}",
                            cluster.at
                        );
                        if excess == 1.0 {
                            needed = needed.max(beyond / margin[k]);
                        }
                    }
                }
            }
        }
    }
    assert!(needed > 0.75, "no vertex needs more than {needed} of the margin");
}
