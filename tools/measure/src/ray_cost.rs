/// What rays of one kind cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCost {
    /// Rays over all frames.
    pub rays: u64,
    /// Share of the rays that hit.
    pub hit_fraction: f64,
    /// By fuzzy trees.
    pub ours: TreeCost,
    /// By a static tree for each frame.
    pub twin: TreeCost,
}

/// What rays cost in one kind of tree.
#[derive(Clone, Copy, Debug, Default)]
pub struct TreeCost {
    /// Million rays per second: all rays over the sum of the frames' median times.
    pub mrays: f64,
    /// Inner nodes visited per ray, top level included.
    pub steps_per_ray: f64,
    /// Triangles posed and tested per ray.
    pub tests_per_ray: f64,
    /// Clusters entered per ray.
    pub clusters_per_ray: f64,
}

impl TreeCost {
    pub(crate) fn entries(&self) -> [(&'static str, f64); 4] {
        [
            ("mrays", self.mrays),
            ("steps_per_ray", self.steps_per_ray),
            ("tests_per_ray", self.tests_per_ray),
            ("clusters_per_ray", self.clusters_per_ray),
        ]
    }
}
