use super::MotionSettings;
use crate::{RayCost, TreeCost};
use serde::Serialize;
use std::collections::BTreeMap;

/// What [`measure_motion`](super::measure_motion) measured.
///
/// "Static" is a tree of the same kind built by the same builder over the posed triangles of the pose at hand and traced by the same
/// runtime: what a tree rebuilt for every frame would be. Ratios are fuzzy over static.
#[derive(Clone, Debug, Serialize)]
pub struct MotionReport {
    /// Name and version of this object's form.
    pub schema: &'static str,
    /// File name of the source.
    pub source: String,
    /// What was asked for.
    pub settings: MotionSettings,
    /// Options of the bake, by name.
    pub options: BTreeMap<String, String>,
    /// Triangles.
    pub triangles: u64,
    /// Vertices.
    pub vertices: u64,
    /// Clusters of all segments.
    pub clusters: u64,
    /// Key whose positions are the rest pose: that of the first part with clusters, in its first segment.
    pub rest_frame: Option<u64>,
    /// Seconds of finding the clusters of all segments, those that segments share once: the sum of `clustering`. What was
    /// tried and dropped is in `bake_seconds` only.
    pub clustering_seconds: f64,
    /// The same by stage.
    pub clustering: ClusteringSeconds,
    /// Seconds of the whole bake, without import and writing.
    pub bake_seconds: f64,
    /// Most memory that the process had taken when the bake was done, import included, bytes; where the system says it.
    pub bake_peak_bytes: Option<u64>,
    /// File size, bytes.
    pub file_bytes: u64,
    /// Steps ratio of `primary`.
    pub steps_ratio: f64,
    /// Intersections ratio of `primary`.
    pub intersections_ratio: f64,
    /// Time ratio of `primary`, frame updates and tree builds not counted.
    pub time_ratio: f64,
    /// Rays of a camera that follows: every pose fills its picture. Over all poses.
    pub primary: Comparison,
    /// Rays of a camera that sees all poses from one place.
    pub wide: Comparison,
    /// Incoherent rays over all poses.
    pub random: Comparison,
    /// Pictures of all poses, per number of threads.
    pub frame_rates: Vec<FrameRate>,
    /// Frame update, microseconds, mean over the poses.
    pub update_us: f64,
    /// Building the static tree of a pose, one thread, milliseconds, mean over the poses.
    pub static_build_ms: f64,
    /// Rays that were compared with brute force; all were compared with the static tree.
    pub brute_force_rays: u64,
    /// Parts with a vertex cache.
    pub parts: Vec<CachedPart>,
    /// The clustering by number of clusters, mean over all segments of all parts (Figure 3.7).
    pub growth: Vec<Growth>,
    /// The poses, in order of time.
    pub frames: Vec<MotionFrame>,
}

impl MotionReport {
    /// What the bake and the frames took, a sentence each.
    #[must_use]
    pub fn facts(&self) -> Vec<String> {
        let stages = self
            .clustering
            .entries()
            .map(|(name, seconds)| format!("{name} {seconds:.2}"));
        let mut out = vec![
            format!("{} triangles, {} clusters", self.triangles, self.clusters),
            format!(
                "bake {:.2} s, clustering {:.2} s ({})",
                self.bake_seconds,
                self.clustering_seconds,
                stages.join(", ")
            ),
        ];
        if let Some(bytes) = self.bake_peak_bytes {
            out.push(format!("peak memory {:.0} MB", bytes as f64 / 1e6));
        }
        for part in &self.parts {
            out.push(format!("{}: {}, {}", part.name, part.class, part.reason));
            out.push(format!(
                "{}: {} segments, {} keys, {:.2} bytes per vertex and key (raw 12), positions within {:e}",
                part.name,
                part.segments.len(),
                part.keys,
                part.bytes_per_vertex_key,
                part.position_error
            ));
            out.push(format!(
                "{}: expected cost {:.1}, with one segment {:.1}, rebuilt {:.1}; {:.2} MB, with one segment {:.2} MB",
                part.name,
                part.expected_cost,
                part.expected_cost_one_segment,
                part.expected_cost_rebuilt,
                part.bytes as f64 / 1e6,
                part.bytes_one_segment as f64 / 1e6
            ));
        }
        for rate in &self.frame_rates {
            out.push(format!(
                "pictures per second on {} threads: {:.2} with update, static {:.2}, built anew {:.2}",
                rate.threads, rate.fuzzy, rate.static_traced, rate.static_built
            ));
        }
        out.push(format!(
            "frame update {:.1} µs, static build {:.2} ms",
            self.update_us, self.static_build_ms
        ));
        out
    }
}

/// Seconds of the stages of clustering.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ClusteringSeconds {
    /// Welding, components, static and rigid ones.
    pub components: f64,
    /// Searches for the rest pose.
    pub rest: f64,
    /// Relaxation.
    pub relax: f64,
    /// Lowering the cost of the fuzzy boxes.
    pub refine: f64,
    /// Principal axes.
    pub axes: f64,
}

impl ClusteringSeconds {
    /// Name and value, in order.
    pub(super) fn entries(&self) -> [(&'static str, f64); 5] {
        [
            ("components", self.components),
            ("rest", self.rest),
            ("relax", self.relax),
            ("refine", self.refine),
            ("axes", self.axes),
        ]
    }
}

/// A part with a vertex cache.
#[derive(Clone, Debug, Serialize)]
pub struct CachedPart {
    /// Node's name, else mesh's name.
    pub name: String,
    /// Motion class.
    pub class: &'static str,
    /// Why.
    pub reason: String,
    /// Key frames.
    pub keys: u64,
    /// Bound of the distance between a stored position and the source's at any key, scene units.
    pub position_error: f64,
    /// Bytes of positions in the file, per vertex and key. Raw `f32` take 12.
    pub bytes_per_vertex_key: f64,
    /// Bytes of clusters, tracks, positions and trees.
    pub bytes: u64,
    /// The same with one segment.
    pub bytes_one_segment: u64,
    /// Expected steps of a ray that meets the part.
    pub expected_cost: f64,
    /// The same with one segment.
    pub expected_cost_one_segment: f64,
    /// Nodes visited and triangles tested in a hierarchy over the posed triangles, expected.
    pub expected_cost_rebuilt: f64,
    /// Time segments; empty in free motion.
    pub segments: Vec<MotionSegment>,
}

/// A time segment.
#[derive(Clone, Debug, Serialize)]
pub struct MotionSegment {
    /// First key.
    pub key_first: u64,
    /// Last key.
    pub key_last: u64,
    /// Clusters.
    pub clusters: u64,
    /// Key whose positions are the rest pose.
    pub rest_frame: u64,
    /// Expected steps of a ray that meets the part.
    pub expected_cost: f64,
    /// Sum of the surfaces of its fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// Seconds of finding its clusters, which it may share with other segments.
    pub clustering_seconds: f64,
    /// The clustering by number of clusters.
    pub growth: Vec<Growth>,
}

/// The clustering with one number of clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// Clusters, static and rigid ones not counted.
    pub clusters: usize,
    /// Root of the mean squared residual motion, scene units.
    pub residual: f64,
    /// Sum of the surfaces of the fuzzy boxes in their local spaces, square scene units.
    pub fuzzy_box_area: f64,
    /// The same with every box as it is in the mesh's space, mean over the keys: what random rays meet.
    pub cost: f64,
}

/// One pose.
#[derive(Clone, Debug, Serialize)]
pub struct MotionFrame {
    /// Time in the clip.
    pub seconds: f32,
    /// Whether it is the time of a key.
    pub at_key: bool,
    /// Frame of the first vertex cache that the clip plays.
    pub cache_frame: Option<f64>,
    /// Its time segment, counted from 0.
    pub segment: Option<usize>,
    /// Clusters in this pose.
    pub clusters: u32,
    /// Those that are traced without their tree, because their frame has no inverse.
    pub clusters_without_inverse: u32,
    /// Key whose positions are the rest pose of the first vertex cache.
    pub rest_frame: Option<u64>,
    /// Of `primary`.
    pub steps_ratio: f64,
    /// Of `primary`.
    pub intersections_ratio: f64,
    /// Of `primary`.
    pub time_ratio: f64,
    /// Rays of the camera that follows.
    pub primary: Comparison,
    /// Rays of the camera that sees all poses.
    pub wide: Comparison,
    /// Incoherent rays.
    pub random: Comparison,
    /// Pictures of this pose, per number of threads.
    pub frame_rates: Vec<FrameRate>,
    /// Frame update (pose, margins, top level), microseconds, median.
    pub update_us: f64,
    /// Building the static tree, one thread, milliseconds.
    pub static_build_ms: f64,
    /// Sum of the surfaces of the posed triangles' own boxes, square scene units.
    pub static_box_area: f64,
}

/// Rays of one kind, by fuzzy trees and by a static tree.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Comparison {
    /// Rays.
    pub rays: u64,
    /// Share of the rays that hit.
    pub hit_fraction: f64,
    /// Inner nodes visited per ray, top level included.
    pub steps: f64,
    /// The same by the static tree.
    pub steps_static: f64,
    /// The former over the latter.
    pub steps_ratio: f64,
    /// Triangles posed and tested per ray.
    pub intersections: f64,
    /// The same by the static tree.
    pub intersections_static: f64,
    /// The former over the latter.
    pub intersections_ratio: f64,
    /// Nanoseconds per ray, on the first number of threads. Vertices that rays share are posed once per frame, before
    /// the timed rounds: the static tree's, too.
    pub time_ns: f64,
    /// The same by the static tree.
    pub time_ns_static: f64,
    /// The former over the latter.
    pub time_ratio: f64,
    /// Clusters entered per ray.
    pub clusters_entered: f64,
}

impl Comparison {
    pub(super) fn new(cost: &RayCost) -> Self {
        let RayCost { ours, twin, .. } = cost;
        let nanoseconds = |tree: &TreeCost| 1e3 / tree.mrays;
        Self {
            rays: cost.rays,
            hit_fraction: cost.hit_fraction,
            steps: ours.steps_per_ray,
            steps_static: twin.steps_per_ray,
            steps_ratio: ours.steps_per_ray / twin.steps_per_ray,
            intersections: ours.tests_per_ray,
            intersections_static: twin.tests_per_ray,
            intersections_ratio: ours.tests_per_ray / twin.tests_per_ray,
            time_ns: nanoseconds(ours),
            time_ns_static: nanoseconds(twin),
            time_ratio: twin.mrays / ours.mrays,
            clusters_entered: ours.clusters_per_ray,
        }
    }
}

/// Pictures per second.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrameRate {
    /// Threads of the rays. Updates and builds run on one, whatever their number.
    pub threads: usize,
    /// Frame update and camera rays by fuzzy trees.
    pub fuzzy: f64,
    /// Camera rays by static trees, as if these cost nothing.
    pub static_traced: f64,
    /// The same with building the trees; posing the vertices is not counted.
    pub static_built: f64,
}

/// Titles of [`Comparison::cells`].
pub const COLUMNS: [&str; 11] = [
    "rays",
    "steps",
    "static",
    "ratio",
    "intersections",
    "static",
    "ratio",
    "ns",
    "static",
    "ratio",
    "hits",
];

/// What the titles mean.
pub const LEGEND: &str = "camera: the pose fills the picture; wide camera: all poses are in it; all per ray; static: the same rays and a tree of the kind built over the posed triangles of that frame; \
                          ns: without frame update and tree build";

impl Comparison {
    /// The comparison as text, short.
    #[must_use]
    pub fn cells(&self, name: &str) -> [String; COLUMNS.len()] {
        [
            name.to_owned(),
            format!("{:.2}", self.steps),
            format!("{:.2}", self.steps_static),
            format!("{:.2}", self.steps_ratio),
            format!("{:.2}", self.intersections),
            format!("{:.2}", self.intersections_static),
            format!("{:.2}", self.intersections_ratio),
            format!("{:.0}", self.time_ns),
            format!("{:.0}", self.time_ns_static),
            format!("{:.2}", self.time_ratio),
            format!("{:.1} %", 100.0 * self.hit_fraction),
        ]
    }
}
