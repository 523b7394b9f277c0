use super::segment::Segment;
use crate::{cost::StructureCost, motion::keyframed::DecomposeReport};
use serde::Serialize;

/// How a vertex cache was baked.
#[derive(Clone, Debug, Serialize)]
pub struct CacheReport {
    /// Key frames.
    pub keys: u64,
    /// Greatest distance between a stored position and the source's at any key, scene units: a bound.
    pub position_error: f64,
    /// Bytes that positions take in the file, per vertex and key frame. Raw `f32` take 12.
    pub bytes_per_vertex_key: f64,
    /// Expected steps of a ray that meets the part, through the fuzzy trees.
    pub expected_cost: f64,
    /// The same with one segment over all keys: what time segments gain.
    pub expected_cost_one_segment: f64,
    /// Expected cost, Eq. 4.1 with constants of 1, of such a ray through the hierarchy that the runtime builds over posed
    /// triangles, mean over a few keys: nodes visited and triangles tested.
    pub expected_cost_rebuilt: f64,
    /// What both ways are expected to take per frame.
    pub expected_frame: ExpectedFrame,
    /// Greatest root of the mean squared residual over the segments, scene units.
    pub residual: f64,
    /// Bytes of clusters, tracks, positions and trees.
    pub bytes: u64,
    /// The same with one segment.
    pub bytes_one_segment: u64,
    /// Time segments; empty in free motion.
    pub segments: Vec<SegmentReport>,
}

impl CacheReport {
    /// Of a cache that is stored as it is.
    pub(super) fn without_clusters(keys: usize, expected_frame: ExpectedFrame) -> Self {
        Self {
            keys: keys as u64,
            position_error: 0.0,
            bytes_per_vertex_key: 12.0,
            expected_cost: 0.0,
            expected_cost_one_segment: 0.0,
            expected_cost_rebuilt: 0.0,
            expected_frame,
            residual: 0.0,
            bytes: 0,
            bytes_one_segment: 0,
            segments: Vec::new(),
        }
    }

    /// Fills in what segments say.
    pub(super) fn add_segments(&mut self, segments: &[Segment], vertex_count: usize) {
        let greatest = |of: &dyn Fn(&Segment) -> f64| segments.iter().map(of).fold(0.0, f64::max);
        self.position_error = greatest(&|segment| segment.stored.error);
        self.residual = greatest(&|segment| segment.residual);
        self.bytes = segments.iter().map(Segment::byte_count).sum();
        let position_bytes: usize = segments
            .iter()
            .map(|segment| size_of_val(segment.stored.words()) + size_of_val(segment.stored.rows.as_slice()))
            .sum();
        self.bytes_per_vertex_key = position_bytes as f64 / (vertex_count as f64 * self.keys as f64);
        self.segments = segments.iter().map(SegmentReport::new).collect();
    }
}

/// What the two ways to trace a part are expected to take per frame, on one thread. The cheaper one decides whether motion
/// that is not rigid is keyframed or free.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExpectedFrame {
    /// Rays of a frame that meet the part: [`BakeSettings::rays_per_frame`](crate::BakeSettings::rays_per_frame).
    pub rays: f64,
    /// Milliseconds with fuzzy trees: preparing their clusters, and the rays.
    pub fuzzy_ms: f64,
    /// Milliseconds with a hierarchy built in the frame: posing all triangles, building, and the rays.
    pub rebuilt_ms: f64,
    /// Rays of a frame for which both take as long; `None` where one is faster for any number.
    pub even_rays: Option<f64>,
}

impl ExpectedFrame {
    pub(super) fn new(costs: &StructureCost, rays: f64) -> Self {
        Self {
            rays,
            fuzzy_ms: costs.fuzzy_milliseconds(rays),
            rebuilt_ms: costs.rebuilt_milliseconds(rays),
            even_rays: costs.even_rays(),
        }
    }
}

impl std::fmt::Display for ExpectedFrame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            rays,
            fuzzy_ms,
            rebuilt_ms,
            even_rays,
        } = self;
        write!(
            f,
            "expected {fuzzy_ms:.3} ms a frame with fuzzy trees, {rebuilt_ms:.3} ms rebuilt, at {rays} rays on one thread"
        )?;
        match even_rays {
            Some(even) => write!(f, "; even at {even:.0} rays"),
            None => Ok(()),
        }
    }
}

/// One time segment.
#[derive(Clone, Debug, Serialize)]
pub struct SegmentReport {
    /// First key that it covers.
    pub key_first: u64,
    /// Last key that it covers.
    pub key_last: u64,
    /// Clusters.
    pub clusters: u64,
    /// Key whose positions are the rest pose, counted in the whole animation.
    pub rest_key: u64,
    /// Key intervals of all clusters through which no tree is used, because the cluster turns over or collapses.
    pub cut_intervals: u64,
    /// Clusters whose nodes have boxes at keys.
    pub clusters_with_key_boxes: u64,
    /// Bytes of these boxes.
    pub key_box_bytes: u64,
    /// Sum of the surface areas of its fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// Expected steps of a ray that meets the part.
    pub expected_cost: f64,
    /// Bytes in the file.
    pub bytes: u64,
    /// How its clusters were found.
    pub decomposition: DecomposeReport,
}

impl SegmentReport {
    pub(super) fn new(segment: &Segment) -> Self {
        let keys = &segment.keys;
        let cut = |cluster: &super::segment::SegmentCluster| {
            (0..cluster.key_bounds.len())
                .filter(|key| cluster.track.is_cut(*key))
                .count() as u64
        };
        let boxes = || segment.clusters.iter().map(|cluster| &cluster.key_boxes);
        Self {
            key_first: *keys.start() as u64,
            key_last: *keys.end() as u64,
            clusters: segment.clusters.len() as u64,
            rest_key: segment.rest_key as u64,
            cut_intervals: segment.clusters.iter().map(cut).sum(),
            clusters_with_key_boxes: boxes().filter(|boxes| boxes.interval > 0).count() as u64,
            key_box_bytes: boxes().map(|boxes| size_of_val(&boxes.rows[..]) as u64).sum(),
            fuzzy_box_area: segment.fuzzy_box_area(),
            expected_cost: segment.cost,
            bytes: segment.byte_count(),
            decomposition: segment.report.clone(),
        }
    }
}
