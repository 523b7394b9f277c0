/// How motion is decomposed.
#[derive(Clone, Debug, PartialEq)]
pub struct DecomposeSettings {
    /// Most clusters, static and rigid ones included. At least 1; default 64. The thesis found 20 to 25 enough (§3.5.1);
    /// here a cluster costs a ray less. Measured with 25 and with 64, primary rays against a tree rebuilt for each frame:
    /// CHICKEN 2.5 and 1.6 times its time, COW 2.9 and 2.0.
    pub max_clusters: usize,
    /// Relaxation for one number of clusters ends when an iteration lowers the residual by less than this part of it.
    /// 0 (only when nothing changes) to 1; default 0.01, the thesis's.
    pub iteration_threshold: f64,
    /// No further cluster is added when the last three lowered the residual (RMS) by less than this part of it each,
    /// on average. 0 (never) to 1; default 0.01.
    pub cluster_threshold: f64,
    /// Most iterations for one number of clusters. At least 1; default 32.
    pub max_iterations: usize,
    /// Every how many key frames one is tried as rest pose. At least 1; default 1: all of them.
    pub rest_step: usize,
    /// Greatest distance, in scene units, between a point of a component called rigid and where its one map puts it, in
    /// any key frame. At least 0; default 0: only what rounding of the source to `f32` explains.
    pub rigid_tolerance: f64,
    /// Whether clusters may turn their local axes to the principal axes of their fuzzy positions, where that lowers
    /// the expected cost; default true.
    pub principal_axes: bool,
}

impl Default for DecomposeSettings {
    fn default() -> Self {
        Self {
            max_clusters: 64,
            iteration_threshold: 0.01,
            cluster_threshold: 0.01,
            max_iterations: 32,
            rest_step: 1,
            rigid_tolerance: 0.0,
            principal_axes: true,
        }
    }
}
