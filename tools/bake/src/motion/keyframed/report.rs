use super::fit::TierCounts;
use serde::Serialize;

/// What the decomposition of one mesh over a range of keys found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DecomposeReport {
    /// Triangles of the mesh on which clusters were looked for: a coarser one where there are many. `steps`, `stop` and
    /// `least_squares_cost` are about that one, costs and tiers beside them about the whole mesh.
    pub searched_triangles: usize,
    /// Key whose points are the rest pose of the clustering.
    pub rest_key: usize,
    /// Keys that were tried as rest pose each time; fewer than all with a rest step, or where all pairs of keys would
    /// cost minutes.
    pub rest_candidates: usize,
    /// One entry per number of clusters, in order (Figure 3.7 of the thesis).
    pub steps: Vec<GrowthStep>,
    /// Why no further cluster was added.
    pub stop: StopReason,
    /// Mean over the keys of the surfaces of all clustered triangles' own boxes, square scene units: what no fuzzy boxes
    /// along the same axes can go below.
    pub ideal_cost: f64,
    /// Cost of the least-squares clustering, as in [`GrowthStep::cost`].
    pub least_squares_cost: f64,
    /// Cost of the final clustering.
    pub cost: f64,
    /// How the final maps were found, over clusters and keys.
    pub tiers: TierCounts,
    /// Clustered clusters with their principal axes as local axes.
    pub turned_clusters: usize,
    /// Components that do not move.
    pub static_components: usize,
    /// Their triangles.
    pub static_triangles: usize,
    /// Components that one map per key explains.
    pub rigid_components: usize,
    /// Their triangles.
    pub rigid_triangles: usize,
    /// Clusters that they share.
    pub rigid_clusters: usize,
    /// Wall-clock seconds by stage.
    pub seconds: DecomposeSeconds,
}

/// The clustering with one number of clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GrowthStep {
    /// Clusters, static and rigid ones not counted.
    pub clusters: usize,
    /// Root of the mean over surface and keys of the squared residual motion, scene units.
    pub residual: f64,
    /// Sum of the surfaces of the fuzzy boxes in their local spaces, square scene units.
    pub fuzzy_box_area: f64,
    /// The same with every box as it is in the mesh's space, averaged over the keys: what random rays meet.
    pub cost: f64,
    /// Iterations of the relaxation.
    pub iterations: usize,
}

/// Why no further cluster was added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// Nothing was left to cluster.
    #[default]
    NothingCoherent,
    /// The residual is down to rounding.
    Exact,
    /// The residual no longer falls by the threshold.
    Converged,
    /// There are as many clusters as allowed.
    MostClusters,
    /// There are as many clusters as triangles.
    MostTriangles,
}

/// Wall-clock seconds of each stage of one decomposition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DecomposeSeconds {
    /// Welding, components, static and rigid ones, normalising.
    pub components: f64,
    /// Making a coarser mesh.
    pub coarse: f64,
    /// Searches for the rest pose.
    pub rest: f64,
    /// Relaxation.
    pub relax: f64,
    /// Lowering the cost of the fuzzy boxes.
    pub refine: f64,
    /// Principal axes.
    pub axes: f64,
}
