use super::Prepared;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Asset,
    cluster_frame::{ClusterFrame, Entering, FrameInputs, Way, invert_frame},
    excess::{Excess, Motions},
    mover_maps::MoverMaps,
    pose_space::PoseSpace,
    refitted_tree::RefittedTree,
    simd::{Lanes, Portable, prefetch},
    vertex::moved,
};
use restpose_formats::rows::{ClusterRow, NONE};
use std::sync::{
    OnceLock,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// Where rounding alone widens a cluster by more than this part of its longest side, as in a palette far from the origin,
/// too little is known of the pose to call it inside.
const UNKNOWN: f64 = 1.0 / 1024.0;

/// Rays that enter a cluster through wider boxes before it is refitted, times the square of the excess relative to its
/// longest side. Of n triangles such a ray tests about n·(2·excess)² at 10 ns, refitting takes 100 ns a triangle; so the
/// two together cost at most twice the better.
const REFIT_RAYS: f64 = 2.5;

/// Where nearly all boxes of a cluster's leaves follow the pose, wider ones above them cost a ray some steps and no tests, about 400 ns,
/// while refitting takes 100 ns a triangle: one ray per so many triangles.
pub(crate) const TRIANGLES_PER_RAY: u32 = 4;

/// A cluster of an instance, and what rays have needed of it.
#[derive(Debug)]
pub(crate) struct ClusterState {
    /// Cluster row.
    pub row: u32,
    /// Cache row that moves its vertices, or `NONE`.
    pub cache: u32,
    posed: OnceLock<PosedCluster>,
    refitted: RefittedTree,
    /// The envelope in which its pose was last found: where to look first.
    nearest_envelope: AtomicU32,
}

/// A cluster in its pose: how rays find its triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedCluster {
    pub frame: ClusterFrame,
    /// How far the pose is from the poses that the cluster's boxes were made for.
    pub excess: Excess,
    /// How its bones move against it.
    pub movers: MoverMaps,
    /// Rays that enter it before it is refitted for its excess; `u32::MAX` for never.
    pub refit_after: u32,
}

impl PosedCluster {
    fn without_excess(frame: ClusterFrame) -> Self {
        Self {
            frame,
            excess: Excess::NONE,
            movers: MoverMaps::NONE,
            refit_after: u32::MAX,
        }
    }
}

impl ClusterState {
    pub(super) fn new(row: u32, cache: u32) -> Self {
        Self {
            row,
            cache,
            posed: OnceLock::new(),
            refitted: RefittedTree::default(),
            nearest_envelope: AtomicU32::new(0),
        }
    }

    /// Begins a pose. What was made of it in an earlier one has been [forgotten](Self::forget).
    pub(super) fn begin(&mut self, row: u32, cache: u32) {
        (self.row, self.cache) = (row, cache);
    }

    /// Asks for what [`Self::forget`] writes: `refitted`, and before it, where rustc puts it, the end of `posed`.
    #[inline]
    pub(super) fn prefetch_to_forget(&self) {
        prefetch(std::slice::from_ref(&self.refitted));
    }

    /// Forgets what was made of it in a pose.
    pub(super) fn forget(&mut self) {
        self.refitted.forget();
        self.posed = OnceLock::new();
    }

    /// Takes it to be found by the tree at a place among the instance's, which was built for its pose.
    pub(super) fn find_by_tree(&mut self, tree: u32, bounds_world: Aabb) {
        let way = Way::Posed(tree);
        self.posed = OnceLock::from(PosedCluster::without_excess(ClusterFrame { bounds_world, way }));
    }

    /// The cluster in its pose, if it was made; else it is made, and `first` called before. Threads that come first at the
    /// same time make it each, all the same.
    #[inline]
    pub(super) fn posed(
        &self,
        first: impl FnOnce(),
        prepared: &Prepared,
        asset: &Asset,
        bounds_world: &Aabb,
        motions: &mut Motions,
    ) -> &PosedCluster {
        if let Some(posed) = self.posed.get() {
            return posed;
        }
        first();
        prefetch(std::slice::from_ref(&self.posed));
        let posed = self.pose(prepared, asset, bounds_world, motions);
        self.posed.get_or_init(|| posed)
    }

    /// What rays have made of it.
    pub(crate) fn posed_so_far(&self) -> Option<&PosedCluster> {
        self.posed.get()
    }

    /// Its tree over posed triangles, if it comes to that. Rays have entered the cluster before.
    #[inline]
    pub(crate) fn refitted(&self) -> &RefittedTree {
        &self.refitted
    }

    /// Compiled for AVX2 where there is one; nothing is fused.
    fn pose(&self, prepared: &Prepared, asset: &Asset, bounds_world: &Aabb, motions: &mut Motions) -> PosedCluster {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = Avx2::new() {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(
                simd: Avx2,
                state: &ClusterState,
                prepared: &Prepared,
                asset: &Asset,
                bounds_world: &Aabb,
                motions: &mut Motions,
            ) -> PosedCluster {
                state.pose_with(simd, prepared, asset, bounds_world, motions)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, prepared, asset, bounds_world, motions) };
        }
        self.pose_with(Portable, prepared, asset, bounds_world, motions)
    }

    #[inline(always)]
    fn pose_with<S: Lanes>(
        &self,
        simd: S,
        prepared: &Prepared,
        asset: &Asset,
        bounds_world: &Aabb,
        motions: &mut Motions,
    ) -> PosedCluster {
        let cluster = &asset.model().clusters[self.row as usize];
        let refitted = || ClusterFrame {
            bounds_world: *bounds_world,
            way: Way::Refitted,
        };
        if self.cache != NONE {
            let frame = self.track_frame(simd, prepared, asset, cluster, bounds_world);
            return PosedCluster::without_excess(frame.unwrap_or_else(refitted));
        }
        // The baker judged poses without an instance transform; what it left out must not be traced here either.
        let Some(inverse) = invert_frame(&prepared.pose.palette[cluster.bone as usize]) else {
            return PosedCluster::without_excess(refitted());
        };
        let model = asset.model();
        let bones = &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
        motions
            .relative
            .update(simd, bones, cluster.bone, &inverse, &prepared.pose.palette);
        let space = asset.pose_spaces().of(model, self.row as usize);
        let excess = match &space {
            Some(space) => self.excess(prepared, asset, cluster, space, motions),
            None => Excess::NONE,
        };
        let (movers, posed_error) = if model.node_movers.is_empty() {
            (MoverMaps::NONE, MoverMaps::UNKNOWN)
        } else {
            // The morphs of a cluster are known with its pose space; most have none.
            let is_morphed = space.as_ref().is_none_or(|space| !space.morphs.is_empty());
            let morph_extent = if is_morphed { prepared.morph_extent() } else { [0.0; 3] };
            MoverMaps::new(simd, asset.rest_lattice(self.row), &motions.relative, morph_extent)
        };
        let entering = Entering::new(simd, &prepared.transform, &motions.relative.largest);
        let (posed, morphed) = (prepared.posed(), prepared.morph_extent());
        let points =
            moved(model, cluster).map(|(bone, [x, y, z])| (bone, [x + morphed[0], y + morphed[1], z + morphed[2]]));
        let inputs = FrameInputs {
            frame: &entering.posed_map(simd, &posed[cluster.bone as usize]),
            bounds_local: &cluster.bounds_local,
            reach: entering.reach(simd, posed, points),
            vertex_error: asset.vertex_error(),
            bounds_world,
            excess: excess.local,
            posed_error,
        };
        PosedCluster {
            frame: ClusterFrame::new(simd, &inputs).unwrap_or_else(refitted),
            excess,
            movers,
            refit_after: refit_after(cluster, &excess).max(asset.rays_of_followers(self.row)),
        }
    }

    #[inline(always)]
    fn excess(
        &self,
        prepared: &Prepared,
        asset: &Asset,
        cluster: &ClusterRow,
        space: &PoseSpace,
        motions: &mut Motions,
    ) -> Excess {
        let weights = &prepared.pose.morph_weights;
        let mut excess = if prepared.clip_bounds_row.is_some() && space.clips_inside {
            motions.inside(space, weights)
        } else {
            let hint = match prepared.clip_bounds_row {
                Some(row) => asset.envelope_hints().of(row, self.row),
                None => &self.nearest_envelope,
            };
            let mut nearest = hint.load(Relaxed).min(space.envelope_count - 1);
            let excess = motions.measure(space, weights, &mut nearest);
            hint.store(nearest, Relaxed);
            excess
        };
        excess.is_outside |= excess.largest() > UNKNOWN * longest_side(cluster);
        excess
    }

    #[inline(always)]
    fn track_frame<S: Lanes>(
        &self,
        simd: S,
        prepared: &Prepared,
        asset: &Asset,
        cluster: &ClusterRow,
        bounds_world: &Aabb,
    ) -> Option<ClusterFrame> {
        let state = &prepared.caches()[self.cache as usize];
        if state.is_cut(asset.model(), cluster.track) {
            return None;
        }
        let inputs = FrameInputs {
            frame: &state.track(cluster.track).frame,
            bounds_local: &cluster.bounds_local,
            reach: state.reach(simd, asset.model(), cluster),
            vertex_error: asset.cache_vertex_error(),
            bounds_world,
            excess: Excess::NONE.local,
            posed_error: MoverMaps::UNKNOWN,
        };
        ClusterFrame::new(simd, &inputs)
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
