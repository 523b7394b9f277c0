use super::{Crossover, FrameSettings, Glance};
use restpose_formats::rows::{ReferenceBoxRow, TriangleRow};
use restpose_runtime::TraceCounters;
use serde::Serialize;

/// What [`measure_frame`](super::measure_frame) measured.
#[derive(Clone, Debug, Serialize)]
pub struct FrameReport {
    /// Name and version of this object's form.
    pub schema: &'static str,
    /// What was asked for.
    pub settings: FrameSettings,
    /// By scene, threads, kind and number of rays, strategy.
    pub frames: Vec<FrameCost>,
    /// Numbers of rays at which one strategy overtakes another.
    pub crossovers: Vec<Crossover>,
    /// What does not depend on rays, per scene and strategy of the runtime.
    pub glances: Vec<Glance>,
    /// Rays compared with brute force; all contestants' hits were compared with the runtime's.
    pub brute_force_rays: u64,
}

/// One strategy's frames with one number of rays.
#[derive(Clone, Debug, Serialize)]
pub struct FrameCost {
    /// File name of the source.
    pub scene: String,
    /// Of all instances, degenerate ones included.
    pub triangles: u64,
    /// Instances.
    pub instances: u64,
    /// `restpose` or a peer.
    pub who: &'static str,
    /// How it makes its frames.
    pub strategy: String,
    /// Threads.
    pub threads: usize,
    /// `none` for frames without rays.
    pub ray_kind: &'static str,
    /// Rays of a frame.
    pub rays: u64,
    /// Frames that were timed.
    pub frames: u64,
    /// Microseconds of a frame from setting poses to the last hit: median.
    pub total_us: f64,
    /// The same: 99th percentile.
    pub p99_us: f64,
    /// The same: least, which a busy machine disturbs less.
    pub least_us: f64,
    /// Microseconds before the first ray: median.
    pub update_us: f64,
    /// Wrong hits per million rays, of those that were compared; 0 for the runtime.
    pub wrong_per_million: f64,
    /// What a frame does; `None` for peers and without rays.
    pub counts: Option<FrameCounts>,
}

/// What a frame does: means.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrameCounts {
    /// Share of the rays that hit.
    pub hit_fraction: f64,
    /// Inner nodes visited.
    pub steps: f64,
    /// Boxes of single triangles tested.
    pub box_tests: f64,
    /// Triangles tested.
    pub tests: f64,
    /// Clusters entered.
    pub clusters: f64,
    /// Instances entered.
    pub instances: f64,
    /// Vertices posed for tests; where an instance is posed whole, its vertices do not count.
    pub vertices_posed: f64,
    /// Upper bound of bytes read: nodes, references, boxes, triangles and posed vertices as often as they are visited.
    pub bytes_touched: f64,
}

/// Bytes of a posed vertex with its stamp.
const VERTEX_BYTES: usize = 16;

impl FrameCounts {
    pub(super) fn new(sum: &TraceCounters, hits: usize, frames: usize, step_bytes: usize) -> Self {
        let per_frame = |count: u64| count as f64 / frames as f64;
        let bytes = sum.steps * step_bytes as u64
            + sum.box_tests * (size_of::<u32>() + size_of::<ReferenceBoxRow>()) as u64
            + sum.triangle_tests * (size_of::<TriangleRow>() + 3 * VERTEX_BYTES) as u64;
        Self {
            hit_fraction: hits as f64 / sum.rays as f64,
            steps: per_frame(sum.steps),
            box_tests: per_frame(sum.box_tests),
            tests: per_frame(sum.triangle_tests),
            clusters: per_frame(sum.clusters_entered),
            instances: per_frame(sum.instances_entered),
            vertices_posed: per_frame(sum.vertices_posed),
            bytes_touched: per_frame(bytes),
        }
    }
}

/// A strategy's frames without rays and with one.
#[derive(Clone, Debug)]
pub struct FixedCost<'a> {
    pub(super) without: &'a FrameCost,
    pub(super) first_ray_us: Option<f64>,
}

impl FrameReport {
    /// Adds another scene's figures.
    pub fn append(&mut self, other: Self) {
        self.frames.extend(other.frames);
        self.crossovers.extend(other.crossovers);
        self.glances.extend(other.glances);
        self.brute_force_rays += other.brute_force_rays;
    }

    /// The frames of every strategy without rays, and with one.
    #[must_use]
    pub fn fixed_costs(&self) -> Vec<FixedCost<'_>> {
        let without = self.frames.iter().filter(|row| row.rays == 0);
        let fixed = without.map(|without| {
            let one = |row: &&FrameCost| row.rays == 1 && row.is_same_strategy(without);
            FixedCost {
                without,
                first_ray_us: self.frames.iter().find(one).map(|row| row.total_us),
            }
        });
        fixed.collect()
    }
}

impl FrameCost {
    /// Whether both stand for one strategy in one scene on as many threads.
    pub(super) fn is_same_strategy(&self, other: &Self) -> bool {
        self.is_same_contest(other) && self.who == other.who && self.strategy == other.strategy
    }

    /// Whether both stand for one scene on as many threads.
    pub(super) fn is_same_contest(&self, other: &Self) -> bool {
        (&self.scene, self.triangles, self.instances, self.threads)
            == (&other.scene, other.triangles, other.instances, other.threads)
    }
}
