use super::{
    PosesSettings,
    candidate::Candidate,
    commit_times::{CommitTimes, commit_times},
    report::{CommitFigures, RayFigures},
    settled_rays::SettledRays,
    turns::trace_seconds,
};
use crate::{MeasureError, Place, checked_rays::counted, clock, posed_rays::corners, view::View};
use rayon::ThreadPool;
use restpose_bake::{
    Progress,
    verify::{BonePose, Oracle, RayKind, Rays},
};
use restpose_runtime::{Frame, InstanceId, PoseError, Posing, Ray, Scene, TraceCounters};

/// Kinds of rays.
const RAY_KINDS: [&str; 2] = ["primary", "random"];

/// Steps and tests that tracing all rays of a kind in a pose takes once, over all candidates: tens of milliseconds. Far
/// outside its pose space a file may have a ray meet the boxes of all triangles.
const WORK: u64 = 1 << 22;

/// Rays whose cost tells how many there is time for.
const PROBE_RAYS: u32 = 64;

/// Rays of a kind in a pose, however much they cost.
const FEWEST_RAYS: u32 = 9;

/// What the poses of a contest have in common.
pub(super) struct Round<'a> {
    pub settings: &'a PosesSettings,
    /// One thread.
    pub pool: &'a ThreadPool,
    /// Of the poses, for messages.
    pub kind: &'static str,
    pub progress: &'a dyn Progress,
}

/// What a candidate did over all poses of a contest.
pub(super) struct Standing {
    /// Camera rays, random rays.
    rays: [RayTotals; 2],
    pose_count: u64,
    clusters: u64,
    clusters_outside: u64,
    largest_excess: f32,
    bone_pairs: u64,
    commits: CommitTimes,
}

#[derive(Clone, Copy, Default)]
struct RayTotals {
    counters: TraceCounters,
    hits: u64,
    missed: u64,
    wrong: u64,
    seconds: f64,
    /// Of the first candidate.
    first_seconds: f64,
}

/// Poses an instance.
pub(super) fn stand(scene: &mut Scene, instance: InstanceId, pose: &BonePose) -> Result<(), PoseError> {
    match pose {
        BonePose::Clip(sample) => clock::pose(scene, instance, sample),
        BonePose::Palette { palette, morph_weights } => scene.set_palette(instance, palette, morph_weights),
    }
}

/// Traces the same rays by all candidates in the same poses. Of the candidates each `group` in a row share their bones and
/// vertices, and one of them at least is guaranteed to miss nothing. Returns what brute force checked, too.
///
/// # Errors
/// A candidate that is guaranteed to miss nothing and does; a pose that one of them does not take.
pub(super) fn contest(
    candidates: &[Candidate],
    group: usize,
    poses: &[BonePose],
    round: &Round,
) -> Result<(Vec<Standing>, u64), MeasureError> {
    let commits = commit_times(candidates, poses)?;
    let mut standings: Vec<Standing> = candidates
        .iter()
        .zip(commits)
        .map(|(candidate, commits)| Standing {
            rays: [RayTotals::default(); 2],
            pose_count: poses.len() as u64,
            clusters: 0,
            clusters_outside: 0,
            largest_excess: 0.0,
            bone_pairs: candidate.bone_pairs,
            commits,
        })
        .collect();
    let mut brute_force_rays = 0;
    for (number, pose) in poses.iter().enumerate() {
        let mut scenes = Vec::with_capacity(candidates.len());
        for candidate in candidates {
            let mut scene = Scene::new();
            let instance = scene.add(&candidate.asset);
            scene.set_posing(instance, Posing::Remembered)?;
            stand(&mut scene, instance, pose)?;
            scenes.push((scene, instance));
        }
        let frames: Vec<(Frame, InstanceId)> = scenes
            .iter_mut()
            .map(|(scene, instance)| (scene.commit(), *instance))
            .collect();
        for ((frame, _), standing) in frames.iter().zip(&mut standings) {
            frame.prepare();
            let stats = frame.stats();
            standing.clusters += u64::from(stats.clusters);
            standing.clusters_outside += u64::from(stats.clusters_outside);
            standing.largest_excess = standing.largest_excess.max(stats.largest_excess);
        }
        let rays = rays(candidates, &frames, round.settings, number);
        for (kind, rays) in rays.iter().enumerate() {
            let place = Place::Drawn {
                subdivisions: candidates[0].file.subdivisions,
                kind: round.kind,
                pose: number,
                rays: RAY_KINDS[kind],
            };
            let groups = candidates
                .chunks(group)
                .zip(frames.chunks(group))
                .zip(standings.chunks_mut(group));
            for ((candidates, frames), standings) in groups {
                let oracle = Oracle::new(&frames[0].0, &[frames[0].1]);
                let contestants: Vec<(Frame, bool)> = candidates
                    .iter()
                    .zip(frames)
                    .map(|(candidate, (frame, _))| (*frame, candidate.is_guaranteed()))
                    .collect();
                let settled = SettledRays::new(&contestants, &oracle, rays, place)?;
                brute_force_rays += settled.brute_force_rays;
                for (standing, found) in standings.iter_mut().zip(&settled.found) {
                    let totals = &mut standing.rays[kind];
                    totals.counters += found.counters;
                    totals.hits += settled.hits;
                    totals.missed += found.missed;
                    totals.wrong += found.wrong;
                }
            }
            let frames: Vec<Frame> = frames.iter().map(|(frame, _)| *frame).collect();
            let seconds = trace_seconds(&frames, rays, round.settings.repeats, round.pool);
            for (standing, own) in standings.iter_mut().zip(&seconds) {
                standing.rays[kind].seconds += own;
                standing.rays[kind].first_seconds += seconds[0];
            }
        }
        round.progress.advance(1);
    }
    Ok((standings, brute_force_rays))
}

/// Camera rays and random rays of a pose, as the first candidate shows it.
fn rays(
    candidates: &[Candidate],
    frames: &[(Frame, InstanceId)],
    settings: &PosesSettings,
    number: usize,
) -> [Vec<Ray>; 2] {
    let (frame, instance) = &frames[0];
    let view = View::filled_by(&corners(frame, *instance, &candidates[0].asset));
    let side = affordable(frames, &view.rays(PROBE_RAYS.isqrt()), settings.rays).isqrt();
    let oracle = Oracle::new(frame, &[*instance]);
    let random = |count: u32| -> Vec<Ray> {
        let mut supply = Rays::new(&oracle, settings.seed.wrapping_add(number as u64));
        (0..count).map(|_| supply.ray(RayKind::Random)).collect()
    };
    let count = affordable(frames, &random(PROBE_RAYS), settings.rays);
    [view.rays(side), random(count)]
}

/// How many rays there is time for, at most `most`, if they cost as much as `probe`.
fn affordable(frames: &[(Frame, InstanceId)], probe: &[Ray], most: u32) -> u32 {
    let work = |(frame, _): &(Frame, InstanceId)| {
        let cost = counted(*frame, probe).1;
        cost.steps + cost.box_tests + cost.triangle_tests
    };
    let work: u64 = frames.iter().map(work).sum();
    let count = WORK.saturating_mul(probe.len() as u64) / work.max(1);
    count.clamp(FEWEST_RAYS.into(), u64::MAX).min(most.into()) as u32
}

impl Standing {
    /// Frames.
    pub fn commits(&self) -> CommitFigures {
        CommitFigures {
            pose_count: self.pose_count,
            clusters: self.clusters,
            clusters_outside: self.clusters_outside,
            largest_excess: self.largest_excess,
            commit_us: self.commits.fresh,
            check_us: self.commits.fresh_check,
            check_again_us: self.commits.again_check,
            bone_pairs: self.bone_pairs,
            check_ns_per_pair: self.commits.fresh_check * 1e3 / self.bone_pairs as f64,
        }
    }

    /// Camera rays, then random rays.
    pub fn rays(&self) -> [RayFigures; 2] {
        std::array::from_fn(|kind| {
            let totals = &self.rays[kind];
            let count = totals.counters.rays as f64;
            let per_ray = |sum: u64| sum as f64 / count;
            RayFigures {
                rays: RAY_KINDS[kind],
                ray_count: totals.counters.rays,
                hit_fraction: per_ray(totals.hits),
                steps: per_ray(totals.counters.steps),
                box_tests: per_ray(totals.counters.box_tests),
                triangle_tests: per_ray(totals.counters.triangle_tests),
                mrays_per_s: count / totals.seconds / 1e6,
                relative_speed: totals.first_seconds / totals.seconds,
                missed_per_million: per_ray(totals.missed) * 1e6,
                wrong_per_million: per_ray(totals.wrong) * 1e6,
            }
        })
    }
}
