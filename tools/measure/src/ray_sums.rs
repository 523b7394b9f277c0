use crate::{MeasureError, RayCost, TreeCost, checked_rays::CheckedRays, clock::trace_seconds};
use rayon::ThreadPool;
use restpose_runtime::{Frame, TraceCounters};
use std::ops::AddAssign;

/// Rays of one kind.
#[derive(Default)]
pub(crate) struct RaySums {
    pub hits: u64,
    pub brute_force_rays: u64,
    /// Fuzzy trees, static tree.
    counters: [TraceCounters; 2],
    /// The same, per pool.
    seconds: Vec<[f64; 2]>,
}

impl RaySums {
    /// Adds what was counted, and what `pools` take for these rays.
    pub fn add(
        &mut self,
        checked: &CheckedRays,
        frames: [Frame; 2],
        repeats: u32,
        pools: &[ThreadPool],
    ) -> Result<(), MeasureError> {
        self.hits += checked.hits.iter().flatten().count() as u64;
        self.brute_force_rays += checked.brute_force_rays;
        for (sum, counters) in self.counters.iter_mut().zip(checked.counters) {
            *sum += counters;
        }
        self.seconds.resize(pools.len(), [0.0; 2]);
        for (sum, pool) in self.seconds.iter_mut().zip(pools) {
            let seconds = pool.install(|| trace_seconds(frames, checked, repeats))?;
            *sum = [sum[0] + seconds[0], sum[1] + seconds[1]];
        }
        Ok(())
    }

    /// What a ray costs in a pool.
    pub fn cost(&self, pool: usize) -> RayCost {
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

impl AddAssign<&Self> for RaySums {
    fn add_assign(&mut self, other: &Self) {
        self.hits += other.hits;
        self.brute_force_rays += other.brute_force_rays;
        for (sum, counters) in self.counters.iter_mut().zip(other.counters) {
            *sum += counters;
        }
        self.seconds
            .resize(self.seconds.len().max(other.seconds.len()), [0.0; 2]);
        for (sum, seconds) in self.seconds.iter_mut().zip(&other.seconds) {
            *sum = [sum[0] + seconds[0], sum[1] + seconds[1]];
        }
    }
}
