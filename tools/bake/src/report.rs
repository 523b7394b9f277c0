use crate::CacheReport;
use restpose_formats::rows::MotionClass;
use serde::Serialize;

/// What a bake found and made.
#[derive(Clone, Debug, Serialize)]
pub struct BakeReport {
    /// Parts, in source order.
    pub parts: Vec<PartReport>,
    /// Triangles of all parts.
    pub triangles: u64,
    /// Triangles that have no area in any pose: numbered, never hit.
    pub degenerate_triangles: u64,
    /// Vertices of all parts.
    pub vertices: u64,
    /// Bones, the asset's own included.
    pub bones: u64,
    /// Clusters.
    pub clusters: u64,
    /// Poses of the pose space from which the boxes were made.
    pub samples: u64,
    /// Random ones among them.
    pub random_poses: u64,
    /// Clips in the file.
    pub clips: u64,
    /// Those of them during all of which the file bounds the asset, so that an instance that plays one has a box without a pose.
    pub clips_bounded: u64,
    /// Sum of the surface areas of all fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// Nodes of all fuzzy trees.
    pub tree_nodes: u64,
    /// Triangle references of all fuzzy trees; more than triangles where boxes overlap split planes.
    pub tree_references: u64,
    /// Seconds by stage, in order.
    pub seconds: StageSeconds,
}

/// How one part was classed.
#[derive(Clone, Debug, Serialize)]
pub struct PartReport {
    /// Node's name, else mesh's name.
    pub name: String,
    /// Motion class.
    #[serde(serialize_with = "class_name")]
    pub class: MotionClass,
    /// Why.
    pub reason: String,
    /// Triangles, degenerate ones included.
    pub triangles: u64,
    /// Clusters that hold some of them.
    pub clusters: u64,
    /// Sum of the surface areas of its fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// Sum of the surface areas of its triangles' boxes in the rest pose: what the fuzzy boxes would be if nothing
    /// moved against its cluster.
    pub rest_box_area: f64,
    /// Of a part with a vertex cache.
    pub cache: Option<CacheReport>,
}

/// Wall-clock seconds of each stage.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct StageSeconds {
    /// Classing parts, laying out rows.
    pub assemble: f64,
    /// Evaluating the sampled poses.
    pub sample: f64,
    /// Choosing each triangle's bone and bounding it there.
    pub decompose: f64,
    /// Envelopes, and the boxes that hold in them.
    pub bound: f64,
    /// Fuzzy trees of static, rigid and skinned parts.
    pub build: f64,
    /// Vertex caches: clusters, tracks, positions, boxes and trees.
    pub caches: f64,
    /// Bounds of the stretches of clips.
    pub clip_bounds: f64,
}

fn class_name<S: serde::Serializer>(class: &MotionClass, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(class.name())
}
