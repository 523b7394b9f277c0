use super::{
    PosesSettings,
    thesis::{ThesisPoseSpace, ThesisTessellation},
};
use serde::Serialize;

/// What [`measure_poses`](super::measure_poses) measured.
///
/// All rows are flat. Where a table compares files they are posed alike and traced by the same rays, in turns, on one
/// thread.
#[derive(Clone, Debug, Serialize)]
pub struct PosesReport {
    /// Name and version of this object's form.
    pub schema: &'static str,
    /// What was asked for.
    pub settings: PosesSettings,
    /// Pose spaces by bounds, at times of one clip. Relative to the clip's own file with sampled bounds.
    pub pose_spaces: Vec<PoseSpaceFigures>,
    /// Bounds by tessellation and kind of poses. Relative to sampled bounds.
    pub bounds: Vec<BoundsFigures>,
    /// Preprocessing and camera rays by tessellation, at times of clips.
    pub tessellations: Vec<TessellationFigures>,
    /// What sampling loses between samples, and what it gains. Relative to sampled bounds as `bake` makes them.
    pub accuracy: Vec<AccuracyFigures>,
    /// Günther's Table 3.1.
    pub thesis_pose_spaces: [ThesisPoseSpace; 4],
    /// Günther's Table 3.3.
    pub thesis_tessellations: [ThesisTessellation; 10],
    /// Rays that were compared with brute force, among them all on which any two files disagreed.
    pub brute_force_rays: u64,
}

impl PosesReport {
    /// Adds the rows of another scene, measured with the same settings.
    pub fn append(&mut self, mut other: Self) {
        self.pose_spaces.append(&mut other.pose_spaces);
        self.bounds.append(&mut other.bounds);
        self.tessellations.append(&mut other.tessellations);
        self.accuracy.append(&mut other.accuracy);
        self.brute_force_rays += other.brute_force_rays;
    }
}

/// A row of Table 3.1.
#[derive(Clone, Debug, Serialize)]
pub struct PoseSpaceFigures {
    /// File.
    #[serde(flatten)]
    pub file: FileFigures,
    /// Rays.
    #[serde(flatten)]
    pub rays: RayFigures,
}

/// One way to bound boxes, in poses of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct BoundsFigures {
    /// File.
    #[serde(flatten)]
    pub file: FileFigures,
    /// Kind of the poses.
    pub poses: &'static str,
    /// Frames.
    #[serde(flatten)]
    pub commits: CommitFigures,
    /// Rays.
    #[serde(flatten)]
    pub rays: RayFigures,
}

/// A row of Table 3.3.
#[derive(Clone, Debug, Serialize)]
pub struct TessellationFigures {
    /// File.
    #[serde(flatten)]
    pub file: FileFigures,
    /// Evaluating poses, choosing bones, bounding triangles, envelopes: seconds of the bake, on all threads.
    pub sampling_seconds: f64,
    /// Building fuzzy trees: the same.
    pub tree_seconds: f64,
    /// Microseconds of preparing a frame, as in [`CommitFigures`].
    pub commit_us: f64,
    /// Pictures of 1024 × 1024 pixels per second on one thread: one over what preparing the frame and that many of the
    /// camera rays take. No shading.
    pub frames_per_s: f64,
    /// Camera rays.
    #[serde(flatten)]
    pub rays: RayFigures,
}

/// A point of the curve of speed against accuracy.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyFigures {
    /// File.
    #[serde(flatten)]
    pub file: FileFigures,
    /// Seconds between samples; none where bounds are envelopes.
    pub sample_step_seconds: Option<f64>,
    /// Whether all key times are sampled, too, as `bake` does.
    pub keys_sampled: bool,
    /// Rays.
    #[serde(flatten)]
    pub rays: RayFigures,
}

/// A baked file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileFigures {
    /// File name of the source.
    pub scene: String,
    /// Times that the source's triangles were split into four.
    pub subdivisions: u32,
    /// Triangles.
    pub triangles: u64,
    /// Pose space.
    pub pose_space: &'static str,
    /// Sampled poses.
    pub samples: u64,
    /// `sampled` or `envelope`.
    pub bounds: &'static str,
    /// Most envelopes of a cluster; none where bounds are sampled.
    pub envelopes: Option<usize>,
    /// Sum of the surface areas of all fuzzy boxes, square scene units.
    pub fuzzy_box_area: f64,
    /// The same relative to the file that the table compares with.
    pub area_ratio: f64,
    /// Mean triangle references of leaves that have any.
    pub triangles_per_leaf: f64,
    /// Length of the file.
    pub bytes: u64,
    /// Bake without import and writing, on all threads.
    pub bake_seconds: f64,
}

/// Preparing frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CommitFigures {
    /// Poses.
    pub pose_count: u64,
    /// Clusters, over all poses.
    pub clusters: u64,
    /// Of these, clusters outside their pose space.
    pub clusters_outside: u64,
    /// Greatest length by which boxes were widened for that, scene units.
    pub largest_excess: f32,
    /// Microseconds of `commit` in a pose that another came before: median over the poses.
    pub commit_us: f64,
    /// Of these, what the check takes: how much longer it is than with sampled bounds, median over the poses.
    pub check_us: f64,
    /// The same where the pose is that of the frame before.
    pub check_again_us: f64,
    /// Pairs of a cluster and a bone beside its own that moves its vertices.
    pub bone_pairs: u64,
    /// `check_us` per pair, nanoseconds; not a number without pairs.
    pub check_ns_per_pair: f64,
}

/// Rays of one kind, over all poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RayFigures {
    /// `primary`: those of a camera whose picture the pose fills. `random`: incoherent, through a box twice the pose's
    /// size.
    pub rays: &'static str,
    /// Rays.
    pub ray_count: u64,
    /// Share of them that hit, by brute force.
    pub hit_fraction: f64,
    /// Inner nodes visited per ray, top level included.
    pub steps: f64,
    /// Boxes of single triangles tested per ray.
    pub box_tests: f64,
    /// Triangles posed and tested per ray.
    pub triangle_tests: f64,
    /// Million rays per second, one thread.
    pub mrays_per_s: f64,
    /// The same relative to the file that the table compares with.
    pub relative_speed: f64,
    /// Rays per million that hit and are found to miss.
    pub missed_per_million: f64,
    /// Rays per million that find another hit than the first.
    pub wrong_per_million: f64,
}
