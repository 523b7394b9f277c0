use super::TessellationsSettings;
use crate::RayCost;
use serde::{Serialize, Serializer, ser::SerializeMap};

/// What [`measure_tessellations`](super::measure_tessellations) measured.
#[derive(Clone, Debug, Serialize)]
pub struct TessellationsReport {
    /// Name and version of this object's form.
    pub schema: &'static str,
    /// File name of the source.
    pub source: String,
    /// What was asked for.
    pub settings: TessellationsSettings,
    /// By subdivisions, then by threads.
    pub rows: Vec<TessellationRow>,
}

/// One tessellation on one number of threads. Means are over the rays of all frames.
///
/// "Static" is a tree of the same kind built over the posed triangles of the frame at hand and traced by the same
/// runtime: what a tree built afresh each frame would be.
#[derive(Clone, Debug)]
pub struct TessellationRow {
    /// Times that the source's triangles were split into four.
    pub subdivisions: u32,
    /// Triangles.
    pub triangles: u64,
    /// Threads of the bake and of ray batches. A frame update runs on one, whatever their number.
    pub threads: usize,
    /// Frame update (pose, margins, top level), microseconds: median over the samples, warm.
    pub update_us: f64,
    /// The same, 99th percentile.
    pub update_p99_us: f64,
    /// Camera rays to the whole model.
    pub primary: RayCost,
    /// Incoherent rays through a box twice the model's size.
    pub random: RayCost,
    /// Bake without import and writing, seconds.
    pub bake_seconds: f64,
    /// File size, bytes.
    pub file_bytes: u64,
    /// Clusters.
    pub clusters: u64,
    /// Nodes of all fuzzy trees.
    pub tree_nodes: u64,
    /// Triangle references of all fuzzy trees.
    pub tree_references: u64,
    /// Sum of the surface areas of all fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// Sum of the surface areas of the posed triangles' own boxes, mean over frames.
    pub static_box_area: f64,
    /// Building the static tree of one frame (exact sweep, one thread), milliseconds, median over frames.
    pub static_build_ms: f64,
    /// Rays of the row that were compared with brute force; all were compared with the static tree.
    pub brute_force_rays: u64,
}

impl Serialize for TessellationRow {
    /// Flat. `steps_per_ray`, `tests_per_ray` and `clusters_per_ray` without a kind are those of random rays; ratios
    /// are ours over static.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_map(None)?;
        row.serialize_entry("subdivisions", &self.subdivisions)?;
        row.serialize_entry("triangles", &self.triangles)?;
        row.serialize_entry("threads", &self.threads)?;
        row.serialize_entry("update_us", &self.update_us)?;
        row.serialize_entry("update_p99_us", &self.update_p99_us)?;
        for (name, value) in &self.random.ours.entries()[1..] {
            row.serialize_entry(name, value)?;
        }
        for (kind, cost) in [("primary", &self.primary), ("random", &self.random)] {
            row.serialize_entry(&format!("rays_{kind}"), &cost.rays)?;
            row.serialize_entry(&format!("hit_fraction_{kind}"), &cost.hit_fraction)?;
            for ((name, ours), (_, twin)) in cost.ours.entries().into_iter().zip(cost.twin.entries()) {
                row.serialize_entry(&format!("{name}_{kind}"), &ours)?;
                row.serialize_entry(&format!("{name}_{kind}_static"), &twin)?;
                row.serialize_entry(&format!("{name}_{kind}_ratio"), &(ours / twin))?;
            }
        }
        row.serialize_entry("bake_seconds", &self.bake_seconds)?;
        row.serialize_entry("file_bytes", &self.file_bytes)?;
        row.serialize_entry("clusters", &self.clusters)?;
        row.serialize_entry("tree_nodes", &self.tree_nodes)?;
        row.serialize_entry("tree_references", &self.tree_references)?;
        row.serialize_entry("fuzzy_box_area", &self.fuzzy_box_area)?;
        row.serialize_entry("static_box_area", &self.static_box_area)?;
        row.serialize_entry("static_build_ms", &self.static_build_ms)?;
        row.serialize_entry("brute_force_rays", &self.brute_force_rays)?;
        row.end()
    }
}

/// Titles of [`TessellationRow::cells`].
pub const COLUMNS: [&str; 15] = [
    "triangles",
    "threads",
    "update µs",
    "p99 µs",
    "primary",
    "static",
    "random",
    "static",
    "steps",
    "static",
    "tests",
    "static",
    "clusters",
    "bake s",
    "file MB",
];

/// What the titles mean.
pub const LEGEND: &str = "primary, random: million rays per second; steps, tests, clusters: per random ray; \
                          static: the same rays and a tree of the kind built over the posed triangles of that frame";

impl TessellationRow {
    /// The row as text, short.
    #[must_use]
    pub fn cells(&self) -> [String; COLUMNS.len()] {
        let (primary, random) = (&self.primary, &self.random);
        [
            self.triangles.to_string(),
            self.threads.to_string(),
            format!("{:.1}", self.update_us),
            format!("{:.1}", self.update_p99_us),
            format!("{:.2}", primary.ours.mrays),
            format!("{:.2}", primary.twin.mrays),
            format!("{:.2}", random.ours.mrays),
            format!("{:.2}", random.twin.mrays),
            format!("{:.1}", random.ours.steps_per_ray),
            format!("{:.1}", random.twin.steps_per_ray),
            format!("{:.2}", random.ours.tests_per_ray),
            format!("{:.2}", random.twin.tests_per_ray),
            format!("{:.2}", random.ours.clusters_per_ray),
            format!("{:.2}", self.bake_seconds),
            format!("{:.2}", self.file_bytes as f64 / 1e6),
        ]
    }
}
