use super::{TessellationRow, TessellationsSettings, baked_level::BakedLevel};
use crate::{
    MeasureError,
    clock::update_times_us,
    posed_rays::PosedRays,
    ray_sums::RaySums,
    statistics::{median, quantile},
};
use rayon::ThreadPool;

/// What the frames of one tessellation sum up to.
#[derive(Default)]
pub(super) struct FrameSums {
    frames: u32,
    primary: RaySums,
    random: RaySums,
    static_build_ms: Vec<f64>,
    static_box_area: f64,
}

impl FrameSums {
    /// Adds a pose.
    pub(super) fn add(&mut self, pose: &PosedRays) {
        self.frames += 1;
        self.static_build_ms.push(pose.static_build_seconds * 1e3);
        self.static_box_area += pose.static_box_area;
        for camera in &pose.cameras {
            self.primary += camera;
        }
        self.random += &pose.random;
    }

    /// The row of one pool.
    pub(super) fn row(
        &mut self,
        baked: &BakedLevel,
        index: usize,
        pool: &ThreadPool,
        settings: &TessellationsSettings,
    ) -> Result<TessellationRow, MeasureError> {
        let samples = baked.asset.model().samples;
        let passes = (settings.updates as usize).div_ceil(samples.len().max(1));
        let mut updates = pool
            .install(|| update_times_us(&baked.asset, samples, passes))?
            .concat();
        Ok(TessellationRow {
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
            tree_nodes: baked.report.tree_nodes,
            tree_references: baked.report.tree_references,
            fuzzy_box_area: baked.report.fuzzy_box_area,
            static_box_area: self.static_box_area / f64::from(self.frames),
            static_build_ms: median(&mut self.static_build_ms),
            brute_force_rays: self.primary.brute_force_rays + self.random.brute_force_rays,
        })
    }
}
