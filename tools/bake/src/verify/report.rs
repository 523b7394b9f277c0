use super::{BonePose, DrawnPose, PoseFamily, PoseSource};
use restpose_formats::{Bounds, rows::NONE};
use restpose_runtime::{FrameStats, Hit, Ray};
use serde::Serialize;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct VerifyReport {
    /// Rays traced, each by `closest_hit`, `any_hit`, and by brute force.
    pub rays: u64,
    /// Poses.
    pub poses: u64,
    /// Where they come from.
    pub pose_source: PoseSource,
    /// Seed of poses and rays.
    pub seed: u64,
    /// How the file's boxes were bounded.
    pub bounds: Bounds,
    /// Poses that the file was baked for.
    pub samples: u64,
    /// Rays that hit something, by brute force.
    pub hits: u64,
    /// Rays that hit by brute force and miss by the runtime, closest or any.
    pub missed: u64,
    /// Rays whose hit differs in any bit, or that hit only by the runtime.
    pub wrong: u64,
    /// Greatest distance between a vertex as posed and the source evaluated in `f64`, relative to the model's size.
    pub max_vertex_error: f64,
    /// Triangles tested by brute force.
    pub oracle_tests: u64,
    /// The families of random poses, each with what was found in its poses.
    pub families: Vec<FamilyReport>,
    /// The first few rays that went wrong, to reproduce them.
    pub failures: Vec<Failure>,
}

/// What was found in the random poses of a family.
#[derive(Clone, Debug, Serialize)]
pub struct FamilyReport {
    /// Family.
    pub family: PoseFamily,
    /// Its poses.
    pub poses: u64,
    /// Rays traced in them.
    pub rays: u64,
    /// Rays that hit something, by brute force.
    pub hits: u64,
    /// As [`VerifyReport::missed`].
    pub missed: u64,
    /// As [`VerifyReport::wrong`].
    pub wrong: u64,
    /// Clusters, over all of its poses.
    pub clusters: u64,
    /// Of these, clusters whose frame had no usable inverse.
    pub clusters_without_inverse: u64,
    /// Of these, clusters whose pose was outside the pose space that their boxes were made for; 0 with sampled bounds.
    pub clusters_outside: u64,
    /// Largest length by which a cluster's boxes were widened for that, in its rest space.
    pub largest_excess: f32,
}

/// A ray whose hit is not the oracle's, and the pose: the same file, pose source, seed and number of poses pose it again.
#[derive(Clone, Debug, Serialize)]
pub struct Failure {
    /// Number of the pose, from 0.
    pub pose: u64,
    /// Where it is random.
    pub family: Option<PoseFamily>,
    /// Row of the sample section, where the pose comes from there.
    pub sample: Option<usize>,
    /// Row of the clip that it is of.
    pub clip: Option<u32>,
    /// Time in that clip.
    pub seconds: Option<f32>,
    /// Frames of the vertex caches.
    pub cache_frames: Vec<f64>,
    /// Ray origin.
    pub origin: [f32; 3],
    /// Ray direction.
    pub direction: [f32; 3],
    /// `t` and triangle by brute force.
    pub expected: Option<(f32, u32)>,
    /// `t` and triangle by the runtime.
    pub found: Option<(f32, u32)>,
}

/// A ray, the oracle's hit, the closest that the runtime found, and whether it found any.
pub(super) type Outcome<'a> = (&'a Ray, Option<Hit>, Option<Hit>, bool);

impl VerifyReport {
    /// Failures that are listed.
    const LISTED: usize = 8;

    /// Adds the rays of a pose.
    pub(super) fn add<'a>(
        &mut self,
        pose: &DrawnPose,
        stats: &FrameStats,
        outcomes: impl Iterator<Item = Outcome<'a>>,
    ) {
        let before = (self.rays, self.hits, self.missed, self.wrong);
        for (ray, expected, found, any) in outcomes {
            self.rays += 1;
            self.hits += u64::from(expected.is_some());
            let missed = expected.is_some() && (found.is_none() || !any);
            let wrong = !missed && (expected != found || any != expected.is_some());
            self.missed += u64::from(missed);
            self.wrong += u64::from(wrong);
            if (missed || wrong) && self.failures.len() < Self::LISTED {
                self.failures.push(Failure::new(pose, ray, expected, found));
            }
        }
        let own = |report: &&mut FamilyReport| Some(report.family) == pose.family;
        if let Some(family) = self.families.iter_mut().find(own) {
            family.poses += 1;
            family.rays += self.rays - before.0;
            family.hits += self.hits - before.1;
            family.missed += self.missed - before.2;
            family.wrong += self.wrong - before.3;
            family.clusters += u64::from(stats.clusters);
            family.clusters_without_inverse += u64::from(stats.clusters_without_inverse);
            family.clusters_outside += u64::from(stats.clusters_outside);
            family.largest_excess = family.largest_excess.max(stats.largest_excess);
        }
    }
}

impl FamilyReport {
    /// Nothing yet.
    pub(super) fn new(family: PoseFamily) -> Self {
        Self {
            family,
            poses: 0,
            rays: 0,
            hits: 0,
            missed: 0,
            wrong: 0,
            clusters: 0,
            clusters_without_inverse: 0,
            clusters_outside: 0,
            largest_excess: 0.0,
        }
    }
}

impl Failure {
    fn new(pose: &DrawnPose, ray: &Ray, expected: Option<Hit>, found: Option<Hit>) -> Self {
        let brief = |hit: Option<Hit>| hit.map(|hit| (hit.t, hit.triangle));
        let clip = match &pose.bones {
            BonePose::Clip(at) if at.clip != NONE => Some(*at),
            _ => None,
        };
        Self {
            pose: pose.index,
            family: pose.family,
            sample: pose.sample,
            clip: clip.map(|at| at.clip),
            seconds: clip.map(|at| at.seconds),
            cache_frames: pose.cache_frames.clone(),
            origin: ray.origin,
            direction: ray.direction,
            expected: brief(expected),
            found: brief(found),
        }
    }
}
