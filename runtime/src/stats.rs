use crate::{asset_instance::Active, cluster_frame::Way};

/// What one frame holds and cost to prepare.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Instances in the scene.
    pub instances: u32,
    /// Clusters of all instances; supplied geometry counts as one each.
    pub clusters: u32,
    /// Clusters whose frame has no usable inverse (scaled to nothing, flattened, near-singular): their triangles were
    /// posed for their bounds, and their tree is refitted when a ray enters those.
    pub clusters_without_inverse: u32,
    /// Clusters of vertex caches whose trees were built for this frame over all of their posed triangles: in free motion,
    /// and where a cluster turns over or collapses between two keys. Supplied geometry counts as one each, whether or not
    /// it had changed.
    pub clusters_rebuilt: u32,
    /// Clusters whose pose is outside the pose space that their boxes were made for, by more than rounding in `f64`. (A
    /// palette that carries its bones far from the origin is itself rounded there, and leaves the pose space by that: let the
    /// instance transform carry them.) They are
    /// traced with wider boxes, and their tree is refitted once so many rays have entered that this pays. Always 0 with
    /// sampled bounds, which do not know.
    pub clusters_outside: u32,
    /// Largest length by which a cluster's boxes are widened for its pose, in the cluster's rest space; inside it is what
    /// rounding adds.
    pub largest_excess: f32,
    /// Nodes of the top-level tree.
    pub top_level_nodes: u32,
    /// Largest length by which a cluster's boxes are widened for every ray, in the cluster's rest space: rounding and
    /// the excess of its pose. What a ray adds in proportion to its distance is not in it.
    pub largest_margin: f32,
}

impl FrameStats {
    pub(crate) fn add(&mut self, clusters: &[Active]) {
        for active in clusters {
            self.clusters_outside += u32::from(active.excess.is_outside);
            self.largest_excess = self.largest_excess.max(active.excess.largest() as f32);
            match &active.frame.way {
                Way::Local(local) => self.largest_margin = self.largest_margin.max(local.largest_margin()),
                Way::Refitted => self.clusters_without_inverse += 1,
                Way::Posed(_) => self.clusters_rebuilt += 1,
            }
        }
    }
}

/// What rays cost. Counted only where asked for; sums over rays. In poses outside their pose space they depend on the rays
/// that came before in the frame, since a cluster is refitted once enough have entered it; hits do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceCounters {
    /// Rays traced.
    pub rays: u64,
    /// Inner nodes visited, top level and clusters.
    pub steps: u64,
    /// Clusters entered.
    pub clusters_entered: u64,
    /// Boxes of single triangles tested, in leaves.
    pub box_tests: u64,
    /// Triangles posed and tested: those whose box the ray meets.
    pub triangle_tests: u64,
}

impl std::ops::AddAssign for TraceCounters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.steps += other.steps;
        self.clusters_entered += other.clusters_entered;
        self.box_tests += other.box_tests;
        self.triangle_tests += other.triangle_tests;
    }
}

/// Where traversal reports what it does; `()` counts nothing and costs nothing.
pub(crate) trait Count {
    fn ray(&mut self) {}
    fn step(&mut self) {}
    fn cluster(&mut self) {}
    fn fuzzy_box(&mut self) {}
    fn triangle(&mut self) {}
}

impl Count for () {}

impl Count for TraceCounters {
    fn ray(&mut self) {
        self.rays += 1;
    }
    fn step(&mut self) {
        self.steps += 1;
    }
    fn cluster(&mut self) {
        self.clusters_entered += 1;
    }
    fn fuzzy_box(&mut self) {
        self.box_tests += 1;
    }
    fn triangle(&mut self) {
        self.triangle_tests += 1;
    }
}
