use super::{
    FrameRow, FrameSettings, RayCost, TreeCost,
    baked_level::BakedLevel,
    checked_rays::{CheckedRays, Place},
    clock::{pose, trace_seconds, update_times_us},
    static_twin::StaticTwin,
    view::View,
};
use crate::{
    MeasureError,
    statistics::{median, quantile},
};
use rayon::ThreadPool;
use restpose_bake::verify::{Oracle, RayKind, Rays};
use restpose_runtime::{Asset, Frame, Scene, TraceCounters};
use std::sync::Arc;

/// What the frames of one tessellation sum up to.
#[derive(Default)]
pub(super) struct FrameSums {
    frames: u32,
    primary: RaySums,
    random: RaySums,
    static_build_ms: Vec<f64>,
    static_box_area: f64,
}

/// Rays of one kind.
#[derive(Default)]
struct RaySums {
    hits: u64,
    brute_force_rays: u64,
    /// Fuzzy trees, static tree.
    counters: [TraceCounters; 2],
    /// The same, per pool.
    seconds: Vec<[f64; 2]>,
}

impl FrameSums {
    /// Poses a frame, builds its static twin, and checks, counts and times its rays.
    pub(super) fn add(
        &mut self,
        asset: &Arc<Asset>,
        place: Place,
        view: &View,
        settings: &FrameSettings,
        pools: &[ThreadPool],
    ) -> Result<(), MeasureError> {
        let mut scene = Scene::new();
        let instance = scene.add(asset);
        pose(&mut scene, instance, &asset.model().samples[place.sample])?;
        let frame = scene.commit();

        let twin = StaticTwin::new(&frame, instance, asset)?;
        let mut twin_scene = Scene::new();
        twin_scene.add(&twin.asset);
        let frames = [frame, twin_scene.commit()];

        let oracle = Oracle::new(&frame, &[instance]);
        let mut supply = Rays::new(&oracle, settings.seed);
        let random = (0..settings.random_rays).map(|_| supply.ray(RayKind::Random)).collect();
        let random = CheckedRays::new(frames, &oracle, random, place)?;
        let primary = CheckedRays::new(frames, &oracle, view.rays(settings.picture_side), place)?;

        self.frames += 1;
        self.static_build_ms.push(twin.report.seconds.build * 1e3);
        self.static_box_area += twin.report.fuzzy_box_area;
        self.primary.add(&primary, frames, settings, pools)?;
        self.random.add(&random, frames, settings, pools)
    }

    /// The row of one pool.
    pub(super) fn row(
        &mut self,
        baked: &BakedLevel,
        index: usize,
        pool: &ThreadPool,
        settings: &FrameSettings,
    ) -> Result<FrameRow, MeasureError> {
        let mut updates = pool.install(|| update_times_us(&baked.asset, settings.updates))?;
        Ok(FrameRow {
            subdivisions: baked.subdivisions,
            triangles: baked.report.triangles,
            threads: pool.current_num_threads(),
            update_us: median(&mut updates),
            update_p99_us: quantile(&mut updates, 0.99),
            primary: self.primary.cost(index),
            random: self.random.cost(index),
            bake_seconds: baked.seconds[index],
            file_bytes: baked.file_bytes,
            clusters: baked.report.clusters,
            kd_nodes: baked.report.tree_nodes,
            kd_references: baked.report.tree_references,
            fuzzy_box_area: baked.report.fuzzy_box_area,
            static_box_area: self.static_box_area / f64::from(self.frames),
            static_build_ms: median(&mut self.static_build_ms),
            brute_force_rays: self.primary.brute_force_rays + self.random.brute_force_rays,
        })
    }
}

impl RaySums {
    fn add(
        &mut self,
        checked: &CheckedRays,
        frames: [Frame; 2],
        settings: &FrameSettings,
        pools: &[ThreadPool],
    ) -> Result<(), MeasureError> {
        self.hits += checked.hits.iter().flatten().count() as u64;
        self.brute_force_rays += checked.brute_force_rays;
        for (sum, counters) in self.counters.iter_mut().zip(checked.counters) {
            *sum += counters;
        }
        self.seconds.resize(pools.len(), [0.0; 2]);
        for (sum, pool) in self.seconds.iter_mut().zip(pools) {
            let seconds = pool.install(|| trace_seconds(frames, checked, settings.repeats))?;
            *sum = [sum[0] + seconds[0], sum[1] + seconds[1]];
        }
        Ok(())
    }

    fn cost(&self, pool: usize) -> RayCost {
        let tree = |kind: usize| {
            let counters = self.counters[kind];
            let per_ray = |count: u64| count as f64 / counters.rays as f64;
            TreeCost {
                mrays: counters.rays as f64 / self.seconds[pool][kind] / 1e6,
                steps_per_ray: per_ray(counters.steps),
                tests_per_ray: per_ray(counters.triangle_tests),
                clusters_per_ray: per_ray(counters.clusters_entered),
            }
        };
        RayCost {
            rays: self.counters[0].rays,
            hit_fraction: self.hits as f64 / self.counters[0].rays as f64,
            ours: tree(0),
            twin: tree(1),
        }
    }
}
