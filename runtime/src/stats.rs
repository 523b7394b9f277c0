use crate::{
    cluster_frame::Way,
    prepared::{ClusterState, Prepared},
};

/// What one frame holds, and what has been needed of it so far: by rays, by calls that ask for vertices, triangles or clusters,
/// and by the commit, which prepares instances with vertex caches and those whose clip the file does not bound. What nobody has
/// reached is not prepared, and not counted. [`Frame::prepare`](crate::Frame::prepare) prepares everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Instances in the scene.
    pub instances: u32,
    /// Instances of assets that were prepared since their pose or place changed.
    pub instances_entered: u32,
    /// Of these, those whose vertices are remembered.
    pub instances_remembered: u32,
    /// Of these, those that were posed whole.
    pub instances_whole: u32,
    /// Clusters that rays have entered. Supplied geometry counts as one each, and clusters in free motion count even
    /// where no ray came.
    pub clusters: u32,
    /// Clusters whose frame has no usable inverse (scaled to nothing, flattened, near-singular), and those of vertex caches
    /// that turn over or collapse between two keys: their triangles were posed and their tree refitted.
    pub clusters_without_inverse: u32,
    /// Clusters in free motion, whose trees were built for this frame over all of their posed triangles. Supplied geometry
    /// counts as one each, whether or not it had changed.
    pub clusters_rebuilt: u32,
    /// Clusters whose pose is outside the pose space that their boxes were made for, by more than rounding in `f64`. (A
    /// palette that carries its bones far from the origin is itself rounded there, and leaves the pose space by that: let the
    /// instance transform carry them.) They are
    /// traced with wider boxes where these do not follow the pose, and their tree is refitted once so many rays have entered that this pays. Always 0 with
    /// sampled bounds, which do not know.
    pub clusters_outside: u32,
    /// Largest length by which a cluster's boxes are widened for its pose, in the cluster's rest space; inside it is what
    /// rounding adds.
    pub largest_excess: f32,
    /// Nodes of the tree over the instances.
    pub top_level_nodes: u32,
    /// Largest length by which a cluster's boxes are widened for every ray, in the cluster's rest space: rounding and
    /// the excess of its pose. What a ray adds in proportion to its distance is not in it.
    pub largest_margin: f32,
}

impl FrameStats {
    pub(crate) fn add(&mut self, prepared: &Prepared) {
        self.instances_entered += 1;
        self.instances_remembered += u32::from(prepared.is_remembered());
        self.instances_whole += u32::from(prepared.is_whole());
        for posed in prepared.clusters.iter().filter_map(ClusterState::posed_so_far) {
            self.clusters += 1;
            self.clusters_outside += u32::from(posed.excess.is_outside);
            self.largest_excess = self.largest_excess.max(posed.excess.largest() as f32);
            match &posed.frame.way {
                Way::Local(local) => self.largest_margin = self.largest_margin.max(local.largest_margin()),
                Way::Refitted => self.clusters_without_inverse += 1,
                Way::Posed(_) => self.clusters_rebuilt += 1,
            }
        }
    }
}

/// What rays cost. Counted only where asked for; sums over rays. In poses outside their pose space, in free motion and in supplied
/// geometry they depend on the rays that came before, since a cluster is refitted and a wide tree made once enough have
/// entered; hits do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceCounters {
    /// Rays traced.
    pub rays: u64,
    /// Inner nodes visited: of the trees over instances, over their clusters and in these.
    pub steps: u64,
    /// Instances entered.
    pub instances_entered: u64,
    /// Clusters entered.
    pub clusters_entered: u64,
    /// Boxes of single triangles tested, in leaves.
    pub box_tests: u64,
    /// Triangles tested: those whose box the ray meets.
    pub triangle_tests: u64,
    /// Vertices posed for them.
    pub vertices_posed: u64,
}

impl std::ops::AddAssign for TraceCounters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.steps += other.steps;
        self.instances_entered += other.instances_entered;
        self.clusters_entered += other.clusters_entered;
        self.box_tests += other.box_tests;
        self.triangle_tests += other.triangle_tests;
        self.vertices_posed += other.vertices_posed;
    }
}

/// Where traversal reports what it does; `()` counts nothing and costs nothing.
pub(crate) trait Count {
    fn ray(&mut self) {}
    fn step(&mut self) {}
    fn instance(&mut self) {}
    fn cluster(&mut self) {}
    fn fuzzy_box(&mut self) {}
    fn triangle(&mut self) {}
    fn vertex(&mut self) {}
}

impl Count for () {}

impl Count for TraceCounters {
    fn ray(&mut self) {
        self.rays += 1;
    }
    fn step(&mut self) {
        self.steps += 1;
    }
    fn instance(&mut self) {
        self.instances_entered += 1;
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
    fn vertex(&mut self) {
        self.vertices_posed += 1;
    }
}
