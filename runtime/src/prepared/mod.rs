//! What rays need of an instance in its pose: made when a ray first enters its box, and no more of it than that ray needs.
//! Threads that come at the same time do not wait for each other, but where a single cluster is refitted
//! ([`RefittedTree`](crate::refitted_tree::RefittedTree)).
//!
//! At once: the palette, its product with the instance transform, world boxes of the clusters and the tree over them. When
//! a ray enters a cluster: its frame, margin and excess ([`cluster_state`]). When it reaches a triangle: its vertices
//! ([`VertexMemo`]). When many have come: all vertices, and a tree over the posed triangles ([`whole`]).

mod cluster_state;
mod kept;
mod pool;
mod whole;

pub(crate) use cluster_state::{ClusterState, PosedCluster, TRIANGLES_PER_RAY};
pub(crate) use pool::PreparedPool;
pub(crate) use whole::Whole;

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Affine, Asset, Pose, PoseEvaluator,
    box_tree::triangle_box,
    cache::CacheState,
    cluster_frame::{Map64, PosedMap, Way},
    excess::Motions,
    motion_bounds::widened_for_motion,
    posed_bounds::morph_extent,
    posed_maps::posed_maps,
    posed_tree::PosedTree,
    posing::{BundleWork, Demand, PosingLimits},
    rest_boxes::{BoneImages, cluster_bounds},
    set_bits::set_bits,
    simd::{Lanes, Portable, SimdLevel, prefetch},
    stats::Count,
    top_level::TopLevel,
    vertex::pose_vertex,
    vertex_memo::VertexMemo,
    whole_pose::{pose_cached_vertices, pose_vertices},
    wide::FuzzyBoxes,
};
use kept::Kept;
use restpose_formats::{
    ModelView,
    rows::{ClusterRow, NONE},
};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// An instance in its pose.
#[derive(Debug, Default)]
pub(crate) struct Prepared {
    /// Unlike that of all others of its pool.
    number: usize,
    pub transform: Affine,
    /// Asset space from rest space, and what goes with it.
    pub pose: Pose,
    /// World space from rest space, per bone row.
    posed: Vec<Affine>,
    morph_extent: [f64; 3],
    /// Per cache row.
    caches: Vec<CacheState>,
    /// What rays may enter: clusters without a track, then those of each cache's present segment.
    pub clusters: Vec<ClusterState>,
    /// World boxes of `clusters`: each contains every posed vertex of its own.
    bounds: Vec<Aabb>,
    /// A bit for each of `clusters` that holds anything of this pose: where no ray came, a new pose leaves its memory alone.
    entered: Vec<AtomicU64>,
    /// Over the clusters, by their place in `clusters`.
    pub top_level: TopLevel,
    /// Trees over posed triangles, of clusters in free motion.
    pub trees: Vec<PosedTree>,
    limits: PosingLimits,
    /// The row of clip bounds, of a stretch of a clip as a rule, that it is a pose of.
    pub clip_bounds_row: Option<usize>,
    demand: Demand,
    memo: Kept<VertexMemo>,
    whole: Kept<Whole>,
}

/// What preparing an instance takes, and nobody needs afterwards: one for each thread that prepares, so that it stays in
/// caches.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    evaluator: PoseEvaluator,
    bones: BoneImages,
}

impl Prepared {
    /// Begins a pose, which `evaluate` writes; where it is of a clip, or the one without any, its row of clip bounds is known.
    ///
    /// Complexity: per bone and cluster, not per triangle, but for free motion.
    pub(crate) fn prepare(
        &mut self,
        pool: &PreparedPool,
        transform: Affine,
        limits: PosingLimits,
        clip_bounds_row: Option<usize>,
        evaluate: impl FnOnce(&mut PoseEvaluator, &mut Pose),
    ) {
        let (asset, simd) = (pool.asset(), SimdLevel::detect());
        self.prefetch();
        let model = asset.model();
        let mut scratch = pool.scratch.take();
        self.demand.begin();
        (self.limits, self.clip_bounds_row) = (limits, clip_bounds_row);
        self.transform = transform;
        evaluate(&mut scratch.evaluator, &mut self.pose);
        self.morph_extent = morph_extent(model, &self.pose.morph_weights);
        posed_maps(simd, &transform, &self.pose.palette, &mut self.posed);
        let transform = Map64::new(&transform);
        self.caches.resize_with(model.caches.len(), CacheState::default);
        for (index, cache) in model.caches.iter().enumerate() {
            let world = [transform, Map64::new(&self.pose.palette[cache.bone as usize])];
            self.caches[index].update(model, cache, self.pose.cache_frames[index], &world);
        }
        let bones = &mut scratch.bones;
        cluster_bounds(simd, asset, &self.posed, self.morph_extent, bones, &mut self.bounds);
        self.place_clusters(asset);
        pool.scratch.put(scratch);
    }

    /// What is about to be written, before the clip is evaluated: of thousands of instances it is in no cache.
    #[inline]
    fn prefetch(&self) {
        prefetch(&self.pose.palette);
        prefetch(&self.posed);
        prefetch(&self.bounds);
        prefetch(self.top_level.nodes());
        for slot in self.entered() {
            self.clusters[slot].prefetch_to_forget();
        }
    }

    /// Places of the clusters that hold anything of this pose.
    fn entered(&self) -> impl Iterator<Item = usize> {
        let words = self.entered.iter().enumerate();
        words
            .flat_map(|(word, entered)| set_bits(entered.load(Relaxed)).map(move |bit| word * u64::BITS as usize + bit))
    }

    /// Gives back what only many rays need.
    fn give_back(&mut self, pool: &PreparedPool) {
        self.memo.give_back(&pool.memos);
        self.whole.give_back(&pool.wholes);
    }

    /// `bounds` are those of the clusters without a track.
    fn place_clusters(&mut self, asset: &Asset) {
        self.forget_clusters();
        let model = asset.model();
        let without_track = self.bounds.len();
        if self.clusters.len() < without_track {
            let rows = self.clusters.len() as u32..without_track as u32;
            self.clusters.extend(rows.map(|row| ClusterState::new(row, NONE)));
        }
        let mut trees = 0;
        for (index, cache) in (0u32..).zip(model.caches) {
            let Some(time) = self.caches[index as usize].time() else {
                continue;
            };
            let segment = &model.segments[time.segment as usize];
            let bone = Map64::new(&self.pose.palette[cache.bone as usize]);
            let bone = PosedMap::product(Portable, &[&Map64::new(&self.transform), &bone]);
            for row in segment.cluster_first..segment.cluster_first + segment.cluster_count {
                let slot = self.bounds.len();
                if slot == self.clusters.len() {
                    self.clusters.push(ClusterState::new(row, index));
                }
                self.clusters[slot].begin(row, index);
                let cluster = &model.clusters[row as usize];
                if model.tracks[cluster.track as usize].key_first == NONE {
                    let tree = self.build_tree(asset, index, cluster, trees);
                    let bounds = self.trees[tree].bounds();
                    self.clusters[slot].find_by_tree(tree as u32, bounds);
                    self.bounds.push(bounds);
                    self.make_room();
                    self.set_entered(slot);
                    trees += 1;
                } else {
                    let bounds = self.caches[index as usize].cluster_bounds(asset, cluster, &bone);
                    self.bounds.push(bounds);
                }
            }
        }
        let count = self.bounds.len();
        self.clusters.truncate(count);
        self.make_room();
        let bounds = |slot: u32| self.bounds[slot as usize];
        if model.caches.is_empty() {
            self.top_level.refit(asset.top_level(), bounds);
        } else {
            self.top_level.rebuild(0..count as u32, bounds);
        }
    }

    /// A bit for each cluster.
    fn make_room(&mut self) {
        let words = self.bounds.len().div_ceil(u64::BITS as usize);
        self.entered.resize_with(words, AtomicU64::default);
    }

    fn set_entered(&self, slot: usize) {
        self.entered[slot / u64::BITS as usize].fetch_or(1 << (slot % u64::BITS as usize), Relaxed);
    }

    fn forget_clusters(&mut self) {
        for (word, entered) in self.entered.iter_mut().enumerate() {
            for bit in set_bits(std::mem::take(entered.get_mut())) {
                self.clusters[word * u64::BITS as usize + bit].forget();
            }
        }
    }

    /// Builds the tree at `place` over a cluster's posed triangles. The place.
    fn build_tree(&mut self, asset: &Asset, cache: u32, cluster: &ClusterRow, place: usize) -> usize {
        if self.trees.len() == place {
            self.trees.push(PosedTree::default());
        }
        let mut tree = std::mem::take(&mut self.trees[place]);
        let model = asset.model();
        let triangles = asset.cluster_triangles(cluster);
        let bound = |triangle| triangle_box(self.recomputed_triangle(model, cache, triangle));
        tree.rebuild(triangles, bound);
        self.trees[place] = tree;
        place
    }

    /// The tree over the posed triangles of a cluster in free motion.
    pub(crate) fn tree_of(&self, cluster: &ClusterState) -> Option<&PosedTree> {
        match cluster.posed_so_far()?.frame.way {
            Way::Posed(tree) => Some(&self.trees[tree as usize]),
            _ => None,
        }
    }

    /// Contains every posed vertex that some triangle with area uses.
    pub(crate) fn bounds(&self) -> Aabb {
        self.top_level.bounds()
    }

    /// The same, widened by what rounding does to vertices that are on their way through a time interval.
    pub(crate) fn bounds_in_motion(&self, asset: &Asset) -> Aabb {
        let frames: Vec<_> = self.caches.iter().map(CacheState::time).collect();
        widened_for_motion(asset, &self.bounds(), &self.transform, &self.pose, &frames)
    }

    /// A cluster with its frame.
    pub(crate) fn cluster(&self, asset: &Asset, slot: u32, motions: &mut Motions) -> (&ClusterState, &PosedCluster) {
        let slot = slot as usize;
        let state = &self.clusters[slot];
        // Who begins the next pose has the clusters alone, and sees which hold anything.
        let first = || self.set_entered(slot);
        (state, state.posed(first, self, asset, &self.bounds[slot], motions))
    }

    /// Where the boxes of a cluster's wide tree are.
    #[inline(always)]
    pub(crate) fn fuzzy_boxes<'a>(
        &'a self,
        model: &ModelView<'a>,
        state: &ClusterState,
        posed: &'a PosedCluster,
    ) -> FuzzyBoxes<'a> {
        let keys = match state.cache {
            NONE => None,
            cache => self.caches[cache as usize].key_boxes(model, &model.clusters[state.row as usize]),
        };
        FuzzyBoxes {
            keys,
            motions: &posed.movers,
            movers: model.node_movers,
        }
    }

    /// Does what the rays that came are worth, for those that enter now. They are to be [counted](Self::count) when it is known
    /// what they cost; where it is the whole, as [many](Self::count_whole) as they are.
    #[inline]
    pub(crate) fn enter(&self, pool: &PreparedPool) -> Option<&Whole> {
        let limits = &self.limits;
        if let Some(whole) = self.whole.get() {
            return Some(whole);
        }
        if limits.is_whole_due(&self.demand, || pool.wholes.in_use()) {
            let pose = |whole: &mut Whole| {
                whole.pose(self, pool.asset());
                whole.beside = pool.wholes.in_use();
            };
            return self.whole.get_or_make(&pool.wholes, pose);
        }
        if limits.is_remembered {
            let vertices = pool.asset().model().vertices.len();
            self.memo.get_or_make(&pool.memos, |memo| memo.begin(vertices));
        }
        None
    }

    /// [`Self::enter`], and counts a ray that goes through the whole.
    #[inline]
    pub(crate) fn enter_counted(&self, pool: &PreparedPool) -> Option<&Whole> {
        let whole = self.enter(pool);
        if whole.is_some() {
            self.count_whole(1);
        }
        whole
    }

    /// Counts rays that went through the whole.
    #[inline]
    pub(crate) fn count_whole(&self, rays: u32) {
        self.demand.count_later(rays, &self.limits);
    }

    /// Counts a ray that tested so many triangles on its way through the clusters.
    #[inline]
    pub(crate) fn count(&self, tests: u32) {
        self.demand.count(tests, &self.limits);
    }

    /// Counts rays that went through the clusters together.
    pub(crate) fn count_bundle(&self, rays: u32, work: &BundleWork) {
        self.demand.count_bundle(rays, work, &self.limits);
    }

    pub(crate) fn demand(&self) -> &Demand {
        &self.demand
    }

    pub(crate) fn is_remembered(&self) -> bool {
        self.memo.get().is_some()
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.whole.get().is_some()
    }

    /// World space from rest space, per bone row.
    pub(crate) fn posed(&self) -> &[Affine] {
        &self.posed
    }

    pub(crate) fn caches(&self) -> &[CacheState] {
        &self.caches
    }

    pub(crate) fn morph_extent(&self) -> [f64; 3] {
        self.morph_extent
    }

    /// Asks for what [`Self::pose_triangle`] reads first of a triangle whose row is near. `cache` is that of its part.
    #[inline]
    pub(crate) fn prefetch_corners(&self, model: &ModelView, cache: u32, triangle: u32) {
        for corner in model.triangles[triangle as usize].corners {
            if let Some(whole) = self.whole.get() {
                prefetch(std::slice::from_ref(&whole.positions[corner as usize]));
            } else if let Some(memo) = self.memo.get() {
                prefetch(memo.row(corner));
            } else if cache == NONE {
                prefetch(std::slice::from_ref(&model.vertices[corner as usize]));
            } else {
                self.caches[cache as usize].prefetch_row(model, corner);
            }
        }
    }

    /// Asks for what it reads next in a part with a vertex cache, whose [corners](Self::prefetch_corners) are near.
    #[inline]
    pub(crate) fn prefetch_stored(&self, model: &ModelView, cache: u32, triangle: u32) {
        for corner in model.triangles[triangle as usize].corners {
            self.caches[cache as usize].prefetch_stored(model, corner);
        }
    }

    /// Poses a triangle's corners in world space. `cache` is that of its part.
    // No closures: they would not be compiled for the instructions that the function around them is.
    #[inline(always)]
    pub(crate) fn pose_triangle<S: Lanes>(
        &self,
        simd: S,
        model: &ModelView,
        cache: u32,
        triangle: u32,
        counters: &mut impl Count,
    ) -> [[f32; 3]; 3] {
        let corners = model.triangles[triangle as usize].corners;
        if let Some(whole) = self.whole.get() {
            return corners.map(|corner| whole.positions[corner as usize]);
        }
        let memo = self.memo.get();
        let mut out = [[0.0; 3]; 3];
        for (position, corner) in out.iter_mut().zip(corners) {
            if let Some(kept) = memo.and_then(|memo| memo.position(corner)) {
                *position = kept;
                continue;
            }
            counters.vertex();
            *position = self.recomputed_vertex(simd, model, cache, corner);
            if let Some(memo) = memo {
                memo.keep(corner, *position);
            }
        }
        out
    }

    /// As [`Self::pose_triangle`].
    #[inline]
    pub(crate) fn pose_triangle_at(
        &self,
        level: SimdLevel,
        model: &ModelView,
        cache: u32,
        triangle: u32,
    ) -> [[f32; 3]; 3] {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(
                simd: Avx2,
                prepared: &Prepared,
                model: &ModelView,
                cache: u32,
                triangle: u32,
            ) -> [[f32; 3]; 3] {
                prepared.pose_triangle(simd, model, cache, triangle, &mut ())
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, model, cache, triangle) };
        }
        self.pose_triangle(Portable, model, cache, triangle, &mut ())
    }

    /// Poses all vertices in world space, on all cores.
    pub(crate) fn pose_all(&self, asset: &Asset, out: &mut Vec<[f32; 3]>) {
        let model = asset.model();
        let (simd, weights) = (SimdLevel::detect(), &self.pose.morph_weights);
        let count = model.vertices.len().saturating_sub(1);
        out.resize(count, [0.0; 3]);
        let ends = model.parts.iter().skip(1).map(|part| part.vertex_first as usize);
        let mut rest = &mut out[..];
        let mut first = 0;
        for (part, end) in model.parts.iter().zip(ends.chain([count])) {
            let (own, others) = rest.split_at_mut(end - first);
            if part.cache == NONE {
                pose_vertices(simd, model, &self.posed, weights, first, own);
            } else {
                pose_cached_vertices(simd, model, &self.caches[part.cache as usize], first, own);
            }
            (rest, first) = (others, end);
        }
    }

    pub(crate) fn recomputed_triangle(&self, model: &ModelView, cache: u32, triangle: u32) -> [[f32; 3]; 3] {
        let corners = model.triangles[triangle as usize].corners;
        corners.map(|corner| self.recomputed_vertex(Portable, model, cache, corner))
    }

    /// Poses a vertex in world space. `cache` is that of its part.
    #[inline(always)]
    pub(crate) fn recomputed_vertex<S: Lanes>(&self, simd: S, model: &ModelView, cache: u32, vertex: u32) -> [f32; 3] {
        let posed = if cache == NONE {
            pose_vertex(simd, model, &self.posed, &self.pose.morph_weights, vertex)
        } else {
            self.caches[cache as usize].pose_vertex(simd, model, vertex)
        };
        let [x, y, z, _] = simd.store4(posed);
        [x, y, z]
    }
}
