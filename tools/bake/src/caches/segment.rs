use super::{
    homes::homes,
    key_boxes::{KeyBoxes, KeyedCluster},
    key_track::KeyTrack,
    stored_positions::{Home, StoredPositions},
};
use crate::{
    BakeError, Progress,
    bounds::FuzzyBox,
    cost::expected_cost,
    fuzzy_tree::{FuzzyTree, FuzzyTreeBuilder},
    motion::keyframed::{DecomposeReport, DecomposeSettings, Decomposition, KeyFrames, TrackKind, decompose_keys},
};
use rayon::prelude::*;
use restpose_formats::{TreeKind, geom::Aabb};
use std::ops::RangeInclusive;

/// 2⁻⁴⁸: rounding of a decoded position in `f64`, relative to the magnitudes that enter it.
const POSITION_ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// How many times fewer clusters are tried where many may cost more than they save.
const CLUSTER_RATIO: usize = 4;

/// Vertices that one task bounds.
const VERTICES_PER_TASK: usize = 256;

/// A part's mesh in all key frames, as its cluster stage sees it.
pub(crate) struct PartKeys<'a> {
    /// Per key, one position per vertex of the part.
    pub frames: Vec<std::borrow::Cow<'a, [[f32; 3]]>>,
    /// Triangles with area, corners counted from the part's first vertex.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex, the least vertex that coincides with it in every key.
    pub weld: Vec<u32>,
    /// Per vertex, whether it is stored as it is because another part stores it too.
    pub raw: Vec<bool>,
}

/// How what a segment holds is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SegmentOutput {
    /// Greatest distance by which a stored position may be off, scene units.
    pub position_error: f64,
    /// What its trees are.
    pub tree: TreeKind,
    /// [`BakeSettings::size_worth`](crate::BakeSettings::size_worth).
    pub size_worth: f64,
}

/// What a segment's clusters, tracks, positions and trees are.
pub(crate) struct Segment {
    /// Keys that it covers.
    pub keys: RangeInclusive<usize>,
    pub clusters: Vec<SegmentCluster>,
    pub stored: StoredPositions,
    /// Key whose positions are the rest pose.
    pub rest_key: usize,
    /// Root of the mean squared residual of its clusters, scene units, before they were refined.
    pub residual: f64,
    /// Expected cost of a ray that meets the part's box, mean over the keys: traversal steps.
    pub cost: f64,
    pub report: DecomposeReport,
}

/// A cluster of a segment.
pub(crate) struct SegmentCluster {
    pub kind: TrackKind,
    pub track: KeyTrack,
    /// Places of its triangles in [`PartKeys::triangles`], ascending.
    pub triangles: Vec<u32>,
    /// Their fuzzy boxes.
    pub boxes: Vec<Aabb>,
    /// Over these.
    pub tree: FuzzyTree,
    /// Around its vertices at each key, in the cache's space.
    pub key_bounds: Vec<Aabb>,
    /// Per vertex of its triangles in order, none twice.
    pub vertices: Vec<u32>,
    /// Boxes of its tree's nodes at keys, and its expected cost.
    pub key_boxes: KeyBoxes,
}

impl Segment {
    /// Decomposes the motion of `part` over `keys`, stores its positions, and builds a tree for each cluster.
    ///
    /// Clusters are added while the residual falls, whatever entering one more costs a ray. So a quarter of the clusters is
    /// tried after, and again, while that lowers the expected cost: on four keys of a gently moving figure 28 clusters cost
    /// 147 steps, one 54.
    pub(crate) fn new(
        part: &PartKeys,
        keys: RangeInclusive<usize>,
        settings: &DecomposeSettings,
        output: SegmentOutput,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let mut best = Self::decomposed(part, keys.clone(), settings, output, progress)?;
        while best.clusters.len() > 1 {
            let fewer = DecomposeSettings {
                max_clusters: (best.clusters.len() / CLUSTER_RATIO).max(1),
                ..settings.clone()
            };
            let other = Self::decomposed(part, keys.clone(), &fewer, output, progress)?;
            if other.cost >= best.cost || other.clusters.len() >= best.clusters.len() {
                break;
            }
            // What growing found stays with what was chosen.
            let steps = std::mem::take(&mut best.report.steps);
            best = other;
            best.report.steps = steps;
        }
        Ok(best)
    }

    fn decomposed(
        part: &PartKeys,
        keys: RangeInclusive<usize>,
        settings: &DecomposeSettings,
        output: SegmentOutput,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let frames = &part.frames[keys.clone()];
        let input = KeyFrames {
            frames: frames.iter().map(AsRef::as_ref).collect(),
            triangles: &part.triangles,
        };
        let Decomposition {
            clusters,
            cluster_of,
            rest_key,
            report,
        } = decompose_keys(&input, settings, progress);
        let tracks = clusters.iter().map(|track| KeyTrack::new(&track.from_local)).collect();
        let kinds: Vec<TrackKind> = clusters.iter().map(|track| track.kind).collect();
        progress.stage("cluster boxes", 0);
        let rest_key = keys.start() + rest_key;
        let residual = report.steps.last().map_or(0.0, |step| step.residual);
        let found = (rest_key, residual, report);
        Self::of_clusters(part, keys, (&kinds, tracks, &cluster_of), output, found)
    }

    /// The same clusters over fewer keys: smaller boxes, and trees over these. `keys` count in the whole animation.
    pub(crate) fn over(
        &self,
        part: &PartKeys,
        keys: RangeInclusive<usize>,
        output: SegmentOutput,
    ) -> Result<Self, BakeError> {
        let own = keys.start() - self.keys.start()..=keys.end() - self.keys.start();
        let kinds: Vec<TrackKind> = self.clusters.iter().map(|cluster| cluster.kind).collect();
        let tracks = self
            .clusters
            .iter()
            .map(|cluster| cluster.track.over(own.clone()))
            .collect();
        let mut cluster_of = vec![0; part.triangles.len()];
        for (number, cluster) in (0u32..).zip(&self.clusters) {
            for triangle in &cluster.triangles {
                cluster_of[*triangle as usize] = number;
            }
        }
        let found = (self.rest_key, self.residual, self.report.clone());
        Self::of_clusters(part, keys, (&kinds, tracks, &cluster_of), output, found)
    }

    fn of_clusters(
        part: &PartKeys,
        keys: RangeInclusive<usize>,
        (kinds, tracks, cluster_of): (&[TrackKind], Vec<KeyTrack>, &[u32]),
        output: SegmentOutput,
        (rest_key, residual, report): (usize, f64, DecomposeReport),
    ) -> Result<Self, BakeError> {
        let frames = &part.frames[keys.clone()];
        let homes = homes(&part.weld, &part.triangles, cluster_of);
        let home = |(cluster, raw): (u32, &bool)| if *raw { Home::Raw } else { Home::Cluster(cluster) };
        let homes: Vec<Home> = homes.into_iter().zip(&part.raw).map(home).collect();
        let stored = StoredPositions::new(frames, &tracks, &homes, output.position_error)?;

        let mut members = vec![Vec::new(); tracks.len()];
        for (triangle, cluster) in (0u32..).zip(cluster_of) {
            members[*cluster as usize].push(triangle);
        }
        let bounded: Vec<Bounded> = members
            .iter()
            .zip(&tracks)
            .map(|(triangles, track)| Bounded::new(part, frames.len(), triangles, track, &tracks, &stored))
            .collect();
        let trees: Vec<FuzzyTree> = bounded
            .par_iter()
            .map_init(
                || FuzzyTreeBuilder::new(output.tree),
                |builder, bounded| builder.build(&bounded.boxes),
            )
            .collect();
        let parts = kinds.iter().zip(tracks).zip(members).zip(bounded).zip(trees);
        let clusters: Vec<SegmentCluster> = parts
            .map(|((((kind, track), triangles), bounded), tree)| SegmentCluster {
                kind: *kind,
                track,
                triangles,
                boxes: bounded.boxes,
                tree,
                key_bounds: bounded.key_bounds,
                vertices: bounded.vertices,
                key_boxes: KeyBoxes::default(),
            })
            .collect();
        let mut out = Self {
            rest_key,
            residual,
            keys,
            clusters,
            stored,
            cost: 0.0,
            report,
        };
        out.add_key_boxes(part, output.size_worth);
        let entered = out.clusters.iter();
        out.cost = expected_cost(entered.map(|cluster| (cluster.key_boxes.cost, cluster.key_bounds.as_slice())));
        Ok(out)
    }

    /// Gives the nodes of clusters boxes at keys where these pay, and all clusters their expected costs.
    fn add_key_boxes(&mut self, part: &PartKeys, worth: f64) {
        let key_count = self.keys.end() - self.keys.start() + 1;
        let bytes = self.byte_count() as f64 / part.triangles.len() as f64;
        let tracks: Vec<&KeyTrack> = self.clusters.iter().map(|cluster| &cluster.track).collect();
        let chosen = |cluster: &SegmentCluster| {
            let cost = cluster.tree.cost();
            match &cluster.tree {
                FuzzyTree::Wide(tree, _) if cluster.kind == TrackKind::Coherent && key_count > 1 => {
                    let triangles = cluster.triangles.iter();
                    let triangles: Vec<_> = triangles.map(|place| part.triangles[*place as usize]).collect();
                    let track = &cluster.track;
                    let keyed = KeyedCluster {
                        tree,
                        track,
                        key_count,
                        triangles: &triangles,
                        local: |vertex: u32, key| track.local(key, self.stored.position(&tracks, vertex as usize, key)),
                        error: track.error(self.stored.reach),
                    };
                    keyed.chosen(cost, bytes * triangles.len() as f64, worth)
                }
                // What does not move in its cluster has tight boxes.
                _ => KeyBoxes {
                    cost,
                    ..KeyBoxes::default()
                },
            }
        };
        let chosen: Vec<KeyBoxes> = self.clusters.par_iter().map(chosen).collect();
        for (cluster, boxes) in self.clusters.iter_mut().zip(chosen) {
            cluster.key_boxes = boxes;
        }
    }

    /// Sum of the surface areas of all fuzzy boxes, square scene units.
    pub(crate) fn fuzzy_box_area(&self) -> f64 {
        let boxes = self.clusters.iter().flat_map(|cluster| &cluster.boxes);
        boxes.map(Aabb::surface_area).sum()
    }

    /// Bytes of its rows in the file.
    pub(crate) fn byte_count(&self) -> u64 {
        use restpose_formats::rows::{ClusterBoneRow, ClusterRow, KeyRow, KeyVertexRow, SegmentRow, TrackRow};
        let keys = self.keys.end() - self.keys.start() + 1;
        let per_cluster = size_of::<ClusterRow>() + size_of::<TrackRow>() + keys * size_of::<KeyRow>();
        let trees: usize = self
            .clusters
            .iter()
            .map(|cluster| {
                let boxes = size_of_val(&cluster.key_boxes.rows[..]);
                cluster.tree.byte_count() + boxes + size_of::<ClusterBoneRow>()
            })
            .sum();
        let positions = size_of_val(self.stored.words()) + self.stored.rows.len() * size_of::<KeyVertexRow>();
        (size_of::<SegmentRow>() + self.clusters.len() * per_cluster + trees + positions) as u64
    }
}

/// The fuzzy boxes of one cluster.
struct Bounded {
    boxes: Vec<Aabb>,
    key_bounds: Vec<Aabb>,
    vertices: Vec<u32>,
}

impl Bounded {
    fn new(
        part: &PartKeys,
        key_count: usize,
        triangles: &[u32],
        track: &KeyTrack,
        tracks: &[KeyTrack],
        stored: &StoredPositions,
    ) -> Self {
        let corners = |triangle: &u32| part.triangles[*triangle as usize];
        let mut vertices: Vec<u32> = triangles.iter().flat_map(corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let chunks: Vec<(Vec<FuzzyBox>, Vec<FuzzyBox>)> = vertices
            .par_chunks(VERTICES_PER_TASK)
            .map(|vertices| {
                let mut at_keys = vec![FuzzyBox::EMPTY; key_count];
                let mut local = vec![[0.0; 3]; key_count];
                let bound = |vertex: &u32| {
                    for (key, local) in local.iter_mut().enumerate() {
                        let position = stored.position(tracks, *vertex as usize, key);
                        at_keys[key].add(position);
                        *local = track.local(key, position);
                    }
                    track.fuzzy_box(&local)
                };
                (vertices.iter().map(bound).collect(), at_keys)
            })
            .collect();
        let mut fuzzy = Vec::with_capacity(vertices.len());
        let mut at_keys = vec![FuzzyBox::EMPTY; key_count];
        for (boxes, keys) in chunks {
            fuzzy.extend(boxes);
            at_keys
                .iter_mut()
                .zip(keys)
                .for_each(|(all, more)| *all = all.union(more));
        }
        let error = track.error(stored.reach);
        let decoding = stored.reach * POSITION_ROUNDING;
        let boxes = triangles
            .iter()
            .map(|triangle| {
                let all = corners(triangle).iter().fold(FuzzyBox::EMPTY, |all, corner| {
                    all.union(fuzzy[vertices.partition_point(|vertex| vertex < corner)])
                });
                all.rounded_outwards(error)
            })
            .collect();
        let key_bounds = at_keys.iter().map(|bounds| bounds.rounded_outwards(decoding)).collect();
        Self {
            boxes,
            key_bounds,
            vertices,
        }
    }
}
