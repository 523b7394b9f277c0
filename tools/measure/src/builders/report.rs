use super::{BuildersSettings, TheirFigures};
use serde::Serialize;

/// What [`measure_builders`](super::measure_builders) measured.
///
/// All rows are flat. Relative numbers compare with `reference`, the first measured builder of the same kind of tree, over
/// the same boxes in the same order; above 1 is better. A number that cannot be had is null.
#[derive(Clone, Debug, Serialize)]
pub struct BuildersReport {
    /// Name and version of this object's form.
    pub schema: &'static str,
    /// What was asked for.
    pub settings: BuildersSettings,
    /// A row per scene, order, builder and number of threads.
    pub builds: Vec<BuildFigures>,
    /// A row per animation and builder that makes use of the frame before.
    pub animations: Vec<AnimationFigures>,
    /// A row per frame of these.
    pub animation_frames: Vec<FrameFigures>,
    /// What the papers report.
    pub theirs: Vec<TheirFigures>,
    /// Rays that were compared with brute force; all were compared with the first builder's.
    pub brute_force_rays: u64,
}

impl BuildersReport {
    /// Adds the rows of another scene, measured with the same settings.
    pub fn append(&mut self, mut other: Self) {
        self.builds.append(&mut other.builds);
        self.animations.append(&mut other.animations);
        self.animation_frames.append(&mut other.animation_frames);
        self.brute_force_rays += other.brute_force_rays;
    }
}

/// One builder over one scene on so many threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuildFigures {
    /// File name of the source, or kind and count of a generated scene.
    pub scene: String,
    /// Triangles, a box each.
    pub triangles: u64,
    /// Whether they are in random order.
    pub shuffled: bool,
    /// `bvh` or `kd`.
    pub tree: &'static str,
    /// Builder.
    pub builder: &'static str,
    /// Where it is described.
    pub source: &'static str,
    /// Whether it is somebody else's.
    pub peer: bool,
    /// Builder that it is compared with.
    pub reference: &'static str,
    /// Threads.
    pub threads: usize,
    /// Builds that were timed.
    pub builds: usize,
    /// Seconds of a build whose builder has built before and keeps its memory: the median. Where one build took longer than
    /// `settings.seconds`, `first_seconds`.
    pub seconds: f64,
    /// Seconds of a builder's first build, with taking memory from the system: the median.
    pub first_seconds: f64,
    /// Million triangles per second, from `seconds`.
    pub mtris_per_s: f64,
    /// The reference's seconds on the first number of threads over these.
    pub speedup: f64,
    /// Seconds of the same builder on the first number of threads over these.
    pub scaling: f64,
    /// Expected cost of the tree by Eq. 4.1, costs of steps and tests as by default.
    pub sah_cost: f64,
    /// The reference's over this.
    pub sah_relative: f64,
    /// Nodes.
    pub nodes: u64,
    /// Entries of leaves.
    pub references: u64,
    /// Inner nodes above the deepest leaf.
    pub depth: u64,
    /// Bytes of nodes and references.
    pub tree_bytes: u64,
    /// Most memory that the build took beside the boxes, the tree included; known on Linux, for two million triangles and
    /// more.
    pub peak_bytes_per_triangle: Option<f64>,
    /// Camera rays.
    pub primary_rays: u64,
    /// Share of them that hit.
    pub primary_hit_fraction: f64,
    /// Inner nodes visited per camera ray.
    pub primary_steps: f64,
    /// Triangles tested per camera ray.
    pub primary_tests: f64,
    /// Million camera rays per second, one thread.
    pub primary_mrays_per_s: f64,
    /// The reference's time over this one's, camera rays.
    pub render_relative: f64,
    /// Random rays.
    pub random_rays: u64,
    /// Share of them that hit.
    pub random_hit_fraction: f64,
    /// Inner nodes visited per random ray.
    pub random_steps: f64,
    /// Triangles tested per random ray.
    pub random_tests: f64,
    /// Million random rays per second, one thread.
    pub random_mrays_per_s: f64,
    /// The reference's time over this one's, random rays.
    pub random_render_relative: f64,
}

/// A builder that makes use of the frame before, over an animation: a row of Hussain and Grahn's Table I. One thread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnimationFigures {
    /// File name of the source.
    pub scene: String,
    /// Triangles.
    pub triangles: u64,
    /// Frames.
    pub frames: u64,
    /// Builder.
    pub builder: &'static str,
    /// Builder that builds each frame afresh, and that it is compared with.
    pub reference: &'static str,
    /// Seconds of the reference: median over the frames but the first, as in what follows.
    pub exact_seconds: f64,
    /// Seconds of the first frame.
    pub initial_seconds: f64,
    /// Seconds of a later frame.
    pub running_seconds: f64,
    /// Share of the reference's seconds that is saved.
    pub reduction: f64,
    /// The SAH cost of the reference's tree over this one's: mean.
    pub sah_relative: f64,
    /// The least of these.
    pub sah_relative_least: f64,
    /// Share of the searched nodes whose plane was found from its prediction: mean. Null where nothing is foreseen, as in what follows.
    pub tracked_fraction: Option<f64>,
    /// Distance of a foreseen plane from the best, in lengths of the box around its node's boxes: mean.
    pub prediction_error: Option<f64>,
    /// Evaluations of the cost in search of a plane that was foreseen: mean.
    pub tracked_steps: Option<f64>,
    /// The same where it was not.
    pub untracked_steps: Option<f64>,
}

/// One frame of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameFigures {
    /// File name of the source.
    pub scene: String,
    /// Counted from 0.
    pub frame: u64,
    /// Builder.
    pub builder: &'static str,
    /// Seconds: median of the passes.
    pub seconds: f64,
    /// Seconds of the reference.
    pub exact_seconds: f64,
    /// Expected cost of the tree by Eq. 4.1.
    pub sah_cost: f64,
    /// The reference's over this.
    pub sah_relative: f64,
    /// As in [`AnimationFigures`].
    pub tracked_fraction: Option<f64>,
    /// As in [`AnimationFigures`].
    pub prediction_error: Option<f64>,
    /// As in [`AnimationFigures`].
    pub tracked_steps: Option<f64>,
    /// As in [`AnimationFigures`].
    pub untracked_steps: Option<f64>,
}
