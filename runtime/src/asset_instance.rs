use crate::{
    Aabb, Affine, Asset, Pose, PoseEvaluator,
    box_tree::{BoxTree, triangle_box},
    build::BvhSettings,
    cache::CacheState,
    cluster_frame::{ClusterFrame, FrameInputs, Map64, PosedMap, Way, invert_frame},
    excess::{BoneMap, Excess, MeasuredPose, Motions},
    refitted_tree::RefittedTree,
    vertex::{pose_vertex, reach},
    vertex_memo::VertexMemo,
};
use restpose_formats::{
    ModelView,
    rows::{CacheRow, ClusterRow, NONE},
};
use std::sync::Arc;

/// Where rounding alone widens a cluster by more than this part of its longest side, as in a palette far from the origin,
/// too little is known of the pose to call it inside.
const UNKNOWN: f64 = 1.0 / 1024.0;

/// Rays that enter a cluster through wider boxes before it is refitted, times the square of the excess relative to its
/// longest side. Of n triangles such a ray tests about n·(2·excess)² at 10 ns, refitting takes 100 ns a triangle; so the
/// two together cost at most twice the better.
const REFIT_RAYS: f64 = 2.5;

/// An instance of an asset: what the caller set, and what the last commit made of it.
#[derive(Debug)]
pub(crate) struct AssetInstance {
    pub asset: Arc<Asset>,
    pub transform: Affine,
    /// Asset space from rest space, and what goes with it.
    pub pose: Pose,
    /// World space from rest space, per bone row.
    pub posed: Vec<Affine>,
    bones: Vec<PosedMap>,
    /// Per cache row.
    caches: Vec<CacheState>,
    /// What this frame traces: clusters without a track, then those of each cache's present segment.
    pub clusters: Vec<Active>,
    /// Per cluster without a track: the envelope in which its pose was last found.
    nearest_envelopes: Vec<u32>,
    motions: Motions,
    /// The palette as poses are measured; empty where no cluster has a pose space.
    bone_maps: Vec<BoneMap>,
    /// Vertices posed in this frame.
    memo: VertexMemo,
    /// Trees over posed triangles, by the order of these among `clusters`.
    pub trees: Vec<BoxTree>,
    /// Per cluster without a track.
    pub refitted: Vec<RefittedTree>,
}

/// A cluster that counts in this frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Active {
    /// Cluster row.
    pub row: u32,
    /// Cache row that moves its vertices, or `NONE`.
    pub cache: u32,
    pub frame: ClusterFrame,
    /// How far the pose is from the poses that the cluster's boxes were made for.
    pub excess: Excess,
    /// Rays that enter it before it is refitted for its excess; `u32::MAX` for never.
    pub refit_after: u32,
}

impl AssetInstance {
    /// An instance at the origin, in the pose without any clip.
    pub(crate) fn new(asset: &Arc<Asset>, evaluator: &mut PoseEvaluator) -> Self {
        let mut pose = Pose::default();
        evaluator.evaluate(asset.model(), None, 0.0, &mut pose);
        Self {
            asset: Arc::clone(asset),
            transform: Affine::IDENTITY,
            pose,
            posed: Vec::new(),
            bones: Vec::new(),
            caches: Vec::new(),
            clusters: Vec::new(),
            nearest_envelopes: vec![0; asset.model().pose_spaces.len()],
            motions: Motions::default(),
            bone_maps: Vec::new(),
            memo: VertexMemo::new(asset.model().vertices.len()),
            trees: Vec::new(),
            refitted: Vec::new(),
        }
    }

    /// Prepares what rays need of this instance.
    pub(crate) fn update(&mut self) {
        let asset = Arc::clone(&self.asset);
        let model = asset.model();
        self.memo.forget();
        let transform = Map64::new(&self.transform);
        let posed = |x: &Affine| PosedMap::product(&[&transform, &Map64::new(x)]);
        self.bones.clear();
        self.bones.extend(self.pose.palette.iter().map(posed));
        self.bone_maps.clear();
        if !model.pose_spaces.is_empty() {
            self.bone_maps.extend(self.pose.palette.iter().map(BoneMap::new));
        }
        self.posed.clear();
        self.posed.extend(self.bones.iter().map(|bone| bone.map));
        self.caches.resize_with(model.caches.len(), CacheState::default);
        for (index, cache) in model.caches.iter().enumerate() {
            let world = [transform, Map64::new(&self.pose.palette[cache.bone as usize])];
            self.caches[index].update(model, cache, self.pose.cache_frames[index], &world);
        }
        self.update_clusters(model);
    }

    fn update_clusters(&mut self, model: &ModelView) {
        self.clusters.clear();
        self.refitted.iter_mut().for_each(RefittedTree::forget);
        let without_track = model.clusters.partition_point(|cluster| cluster.track == NONE);
        self.refitted.resize_with(without_track, RefittedTree::default);
        let morph_extent = self.morph_extent(model);
        for (row, cluster) in (0..).zip(&model.clusters[..without_track]) {
            let (frame, excess) = self.bone_frame(model, row, morph_extent);
            let frame = frame.unwrap_or_else(|| self.posed_bounds(model, cluster));
            self.clusters.push(Active {
                row,
                cache: NONE,
                frame,
                excess,
                refit_after: refit_after(cluster, &excess),
            });
        }
        let mut trees = 0;
        for (index, cache) in (0u32..).zip(model.caches) {
            let Some(time) = self.caches[index as usize].time() else {
                continue;
            };
            let segment = &model.segments[time.segment as usize];
            for row in segment.cluster_first..segment.cluster_first + segment.cluster_count {
                let cluster = &model.clusters[row as usize];
                let free = model.tracks[cluster.track as usize].key_first == NONE;
                let frame = (!free)
                    .then(|| self.track_frame(model, index, cache, cluster))
                    .flatten();
                let frame = frame.unwrap_or_else(|| {
                    trees += 1;
                    self.posed_frame(model, index, cluster, trees)
                });
                self.clusters.push(Active {
                    row,
                    cache: index,
                    frame,
                    excess: Excess::NONE,
                    refit_after: u32::MAX,
                });
            }
        }
    }

    fn morph_extent(&self, model: &ModelView) -> [f64; 3] {
        let mut extent = [0.0; 3];
        for (target, weight) in model.morph_targets.iter().zip(&self.pose.morph_weights) {
            for k in 0..3 {
                extent[k] += f64::from(weight.abs()) * f64::from(target.extent[k]);
            }
        }
        extent
    }

    fn bone_frame(&mut self, model: &ModelView, row: u32, morph_extent: [f64; 3]) -> (Option<ClusterFrame>, Excess) {
        let cluster = &model.clusters[row as usize];
        // The baker judged poses without an instance transform; what it left out must not be traced here either.
        let Some(inverse) = invert_frame(&self.pose.palette[cluster.bone as usize]) else {
            return (None, Excess::NONE);
        };
        let excess = match self.asset.pose_spaces().of(model, row as usize) {
            None => Excess::NONE,
            Some(space) => {
                let pose = MeasuredPose {
                    bones: &self.bone_maps,
                    morph_weights: &self.pose.morph_weights,
                };
                let nearest = &mut self.nearest_envelopes[row as usize];
                let mut excess = self
                    .motions
                    .measure(&space, cluster.bone as usize, &inverse, pose, nearest);
                excess.is_outside |= excess.largest() > UNKNOWN * longest_side(cluster);
                excess
            }
        };
        let frame = ClusterFrame::new(&FrameInputs {
            frame: &self.bones[cluster.bone as usize],
            bounds_local: &cluster.bounds_local,
            reach: reach(model, cluster, |bone, extent| {
                let extent = std::array::from_fn(|k| extent[k] + morph_extent[k]);
                self.bones[bone as usize].reach(extent)
            }),
            vertex_error: self.asset.vertex_error(),
            bounds: None,
            excess: excess.local,
        });
        (frame, excess)
    }

    fn track_frame(
        &self,
        model: &ModelView,
        index: u32,
        cache: &CacheRow,
        cluster: &ClusterRow,
    ) -> Option<ClusterFrame> {
        let state = &self.caches[index as usize];
        let bounds = state.bounds(model, cluster.track)?;
        ClusterFrame::new(&FrameInputs {
            frame: &state.track(cluster.track).frame,
            bounds_local: &cluster.bounds_local,
            reach: reach(model, cluster, |track, extent| state.track(track).reach(extent)),
            vertex_error: self.asset.cache_vertex_error(),
            bounds: Some((&bounds, &self.bones[cache.bone as usize])),
            excess: Excess::NONE.local,
        })
    }

    /// Bounds a bone's cluster by its posed vertices, where the bone has no usable inverse. Most often such a bone hides a
    /// limb by scaling it to nothing, and no ray comes.
    fn posed_bounds(&self, model: &ModelView, cluster: &ClusterRow) -> ClusterFrame {
        let references = &model.references[cluster.reference_first as usize..][..cluster.reference_count as usize];
        ClusterFrame {
            bounds_world: Aabb::around(
                references
                    .iter()
                    .flat_map(|triangle| self.pose_triangle(NONE, *triangle))
                    // Vertices that overflowed have no place and hit nothing.
                    .filter(|vertex| vertex.iter().all(|x| x.is_finite())),
            ),
            way: Way::Refitted,
        }
    }

    /// Builds the `count`th tree over posed triangles: of free motion, or where a track turns over between two keys.
    fn posed_frame(&mut self, model: &ModelView, cache: u32, cluster: &ClusterRow, count: usize) -> ClusterFrame {
        if self.trees.len() < count {
            self.trees.resize_with(count, BoxTree::default);
        }
        let mut tree = std::mem::take(&mut self.trees[count - 1]);
        let rows = cluster.reference_first as usize..(cluster.reference_first + cluster.reference_count) as usize;
        let references = model.references[rows.clone()].iter();
        let first = &self.asset.first_references()[rows];
        let triangles = references
            .zip(first)
            .filter(|(_, first)| **first)
            .map(|(triangle, _)| *triangle);
        let bound = |triangle| triangle_box(self.pose_triangle(cache, triangle));
        tree.rebuild(triangles, bound, &BvhSettings::default());
        let bounds_world = tree.bounds();
        self.trees[count - 1] = tree;
        ClusterFrame {
            bounds_world,
            way: Way::Posed(count as u32 - 1),
        }
    }

    /// The cache that moves a part's vertices, by the part's triangle or vertex row; `NONE` without one.
    pub(crate) fn cache_of_triangle(&self, triangle: u32) -> u32 {
        let parts = self.asset.model().parts;
        let after = parts.partition_point(|part| part.triangle_first <= triangle);
        after.checked_sub(1).map_or(NONE, |part| parts[part].cache)
    }

    /// As [`AssetInstance::cache_of_triangle`].
    pub(crate) fn cache_of_vertex(&self, vertex: u32) -> u32 {
        let parts = self.asset.model().parts;
        let after = parts.partition_point(|part| part.vertex_first <= vertex);
        after.checked_sub(1).map_or(NONE, |part| parts[part].cache)
    }

    /// Poses a triangle's corners in world space. `cache` is that of its part.
    #[inline]
    pub(crate) fn pose_triangle(&self, cache: u32, triangle: u32) -> [[f32; 3]; 3] {
        self.asset.model().triangles[triangle as usize]
            .corners
            .map(|corner| self.pose_vertex(cache, corner))
    }

    /// Poses a vertex in world space, once per frame. `cache` is that of its part.
    #[inline]
    pub(crate) fn pose_vertex(&self, cache: u32, vertex: u32) -> [f32; 3] {
        self.memo.position(vertex, || {
            let model = self.asset.model();
            if cache == NONE {
                pose_vertex(model, &self.posed, &self.pose.morph_weights, vertex)
            } else {
                self.caches[cache as usize].pose_vertex(model, vertex)
            }
        })
    }
}

fn refit_after(cluster: &ClusterRow, excess: &Excess) -> u32 {
    let relative = excess.largest() / longest_side(cluster);
    // The cast saturates, and makes a NaN zero.
    (REFIT_RAYS / (relative * relative)) as u32
}

fn longest_side(cluster: &ClusterRow) -> f64 {
    let bounds = &cluster.bounds_local;
    (0..3).fold(0.0, |longest: f64, k| {
        longest.max(f64::from(bounds.max[k]) - f64::from(bounds.min[k]))
    })
}
