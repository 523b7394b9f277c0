use super::{
    contestant::{Contestant, Tracing},
    contestants::{Named, contestants},
    crowd::Crowd,
    ray_sets::RaySet,
    reference::{CheckedSet, Reference},
    report::{FrameCost, FrameCounts},
    scene::FrameScene,
    settings::FrameSettings,
};
use crate::{
    MeasureError,
    statistics::{median, quantile},
};
use rayon::ThreadPool;
use restpose_bake::Progress;
use restpose_runtime::{Hit, Ray, TraceCounters};
use std::{sync::Arc, time::Instant};

/// Share of a peer's hits that may be wrong: some peers are known to lose 2 % of them to a fixed least determinant. The
/// rows say how many.
const MOST_WRONG: f64 = 0.05;

/// Rays of the frame before a turn, which is not timed.
const WARMING_RAYS: usize = 1024;

/// Frames that are counted where they have few rays, in turns.
const COUNTED_FRAMES: usize = 64;

/// All contestants, one number of threads after the other.
pub(super) struct Contest<'a> {
    scene: String,
    crowd: Arc<Crowd>,
    reference: &'a Reference,
    settings: &'a FrameSettings,
    /// Sets of rays, of none first.
    sets: Vec<Option<RaySet>>,
    /// What frames count, by contestant and set: does not depend on threads.
    counts: Vec<Vec<Option<FrameCounts>>>,
    pub rows: Vec<FrameCost>,
}

impl<'a> Contest<'a> {
    pub(super) fn new(
        scene: &FrameScene,
        crowd: &Arc<Crowd>,
        reference: &'a Reference,
        settings: &'a FrameSettings,
    ) -> Self {
        let most = settings.rays.iter().copied().max().unwrap_or(0);
        let mut sets = vec![None];
        for kind in &settings.ray_kinds {
            let mut last = 0;
            for count in &settings.rays {
                let set = RaySet::new(*kind, *count, most, &reference.bounds, settings.seed);
                // Small pictures have one tile, whatever their number of rays.
                if set.count != std::mem::replace(&mut last, set.count) {
                    sets.push(Some(set));
                }
            }
        }
        Self {
            scene: scene.name.clone(),
            crowd: Arc::clone(crowd),
            reference,
            settings,
            sets,
            counts: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Steps of progress of so many pools.
    pub(super) fn steps(&self, pools: usize) -> u64 {
        (self.sets.len() * pools) as u64
    }

    /// Measures on the threads of a pool.
    pub(super) fn run(
        &mut self,
        scene: &FrameScene,
        pool: &ThreadPool,
        progress: &dyn Progress,
    ) -> Result<(), MeasureError> {
        let mut all = contestants(scene, &self.crowd, self.settings, pool.current_num_threads())?;
        let mut wrong = Vec::new();
        for set in &self.reference.sets {
            wrong.push(pool.install(|| self.check(&mut all, set))?);
        }
        if self.counts.is_empty() {
            self.counts = self.count(&mut all)?;
        }
        let sets = std::mem::take(&mut self.sets);
        for (index, set) in sets.iter().enumerate() {
            let kind = set.as_ref().map(|set| set.kind);
            let checked = self.reference.sets.iter().position(|set| Some(set.rays.kind) == kind);
            let wrong = checked.map(|kind| wrong[kind].as_slice());
            self.time(&mut all, index, set.as_ref(), wrong, pool)?;
            progress.advance(1);
        }
        self.sets = sets;
        Ok(())
    }

    /// Compares the hits of all contestants in all poses. Gives each one's wrong hits per ray.
    fn check(&self, all: &mut [Named], set: &CheckedSet) -> Result<Vec<[f64; 2]>, MeasureError> {
        let mut wrong = vec![[0usize; 2]; all.len()];
        let error = self.reference.peer_error();
        let poses = self.crowd.poses.len();
        for pose in 0..poses {
            let rays = set.rays.of_frame(pose);
            let mut known: Option<(&'static str, Vec<Option<Hit>>)> = None;
            for (Named { name, contestant }, wrong) in all.iter_mut().zip(&mut wrong) {
                for tracing in contestant.tracings() {
                    contestant.set_rays(rays, *tracing);
                    contestant.frame(pose)?;
                    match (contestant.hits(), &known) {
                        (Some(hits), None) => {
                            if pose == 0 {
                                set.compare(name, hits)?;
                            }
                            known = Some((*name, hits.to_vec()));
                        }
                        (Some(hits), Some((first, known))) => {
                            set.compare_all((name, hits), (first, known), pose)?;
                        }
                        (None, Some((_, known))) => {
                            let found = wrong_distances(rays, &contestant.distances(), known, error);
                            wrong[*tracing as usize] += found;
                            let hits = known.iter().flatten().count();
                            if found as f64 > MOST_WRONG * hits as f64 {
                                return Err(MeasureError::WrongFrame {
                                    scene: self.scene.clone(),
                                    strategy: name,
                                    pose,
                                    rays: set.rays.kind.name(),
                                    wrong: found,
                                    count: rays.len(),
                                });
                            }
                        }
                        (None, None) => {
                            return Err(MeasureError::NoStrategy {
                                scene: self.scene.clone(),
                            });
                        }
                    }
                }
            }
        }
        let share = |wrong: usize| wrong as f64 / (poses * set.rays.count) as f64;
        Ok(wrong.into_iter().map(|wrong| wrong.map(share)).collect())
    }

    fn count(&self, all: &mut [Named]) -> Result<Vec<Vec<Option<FrameCounts>>>, MeasureError> {
        let poses = self.crowd.poses.len();
        let mut out = Vec::new();
        for Named { contestant, .. } in all {
            let mut counts = vec![None; self.sets.len()];
            for (counts, set) in counts.iter_mut().zip(&self.sets) {
                let Some(set) = set else { continue };
                let frames = if set.count < WARMING_RAYS {
                    COUNTED_FRAMES.max(poses)
                } else {
                    1
                };
                let (mut sum, mut hits) = (TraceCounters::default(), 0);
                for frame in 0..frames {
                    contestant.set_rays(set.of_frame(frame), Tracing::Single);
                    let Some(counters) = contestant.counted(frame % poses)? else {
                        break;
                    };
                    sum += counters;
                    hits += contestant.hits().map_or(0, |hits| hits.iter().flatten().count());
                }
                if sum.rays > 0 {
                    *counts = Some(FrameCounts::new(&sum, hits, frames, contestant.step_bytes()));
                }
            }
            out.push(counts);
        }
        Ok(out)
    }

    /// Times frames of one set of rays, contestants in turns.
    fn time(
        &mut self,
        all: &mut [Named],
        index: usize,
        set: Option<&RaySet>,
        wrong: Option<&[[f64; 2]]>,
        pool: &ThreadPool,
    ) -> Result<(), MeasureError> {
        let coherent = set.is_some_and(|set| set.kind.is_coherent());
        let mut entries = Vec::new();
        for (place, Named { contestant, .. }) in all.iter().enumerate() {
            let tracings = contestant.tracings().iter();
            entries.extend(
                tracings
                    .filter(|tracing| coherent || **tracing == Tracing::Single)
                    .map(|tracing| (place, *tracing, Times::default())),
            );
        }
        for turn in 0..self.settings.turns as usize {
            let mut resting = true;
            for step in 0..entries.len() {
                // Forth and back: of two that share a file, the second finds in caches what the first has read.
                let entry = if turn % 2 == 0 { step } else { entries.len() - 1 - step };
                let (place, tracing, times) = &mut entries[entry];
                if turn > 0 && times.seconds >= self.settings.seconds {
                    continue;
                }
                resting = false;
                let contestant = all[*place].contestant.as_mut();
                pool.install(|| self.turn(contestant, *tracing, set, turn, times))?;
            }
            if resting {
                break;
            }
        }
        for (place, tracing, mut times) in entries {
            let counts = self.counts[place][index];
            let (who, strategy) = all[place].name.split_once('-').unwrap_or((all[place].name, ""));
            let packets = if tracing == Tracing::Packets { ", packets" } else { "" };
            self.rows.push(FrameCost {
                scene: self.scene.clone(),
                triangles: self.crowd.asset.model().triangles.len() as u64 * self.crowd.transforms.len() as u64,
                instances: self.crowd.transforms.len() as u64,
                who,
                strategy: format!("{strategy}{packets}"),
                threads: pool.current_num_threads(),
                ray_kind: set.map_or("none", |set| set.kind.name()),
                rays: set.map_or(0, |set| set.count as u64),
                frames: times.total_us.len() as u64,
                total_us: median(&mut times.total_us),
                p99_us: quantile(&mut times.total_us, 0.99),
                least_us: quantile(&mut times.total_us, 0.0),
                update_us: median(&mut times.update_us),
                wrong_per_million: wrong.map_or(0.0, |wrong| 1e6 * wrong[place][tracing as usize]),
                counts,
            });
        }
        Ok(())
    }

    /// A frame of every pose.
    fn turn(
        &self,
        contestant: &mut dyn Contestant,
        tracing: Tracing,
        set: Option<&RaySet>,
        turn: usize,
        times: &mut Times,
    ) -> Result<(), MeasureError> {
        let poses = self.crowd.poses.len();
        let rays = |frame: usize| set.map_or(&[][..], |set| set.of_frame(frame));
        contestant.set_rays(&rays(0)[..rays(0).len().min(WARMING_RAYS)], tracing);
        contestant.frame(poses - 1)?;
        let mut last: Option<&[Ray]> = None;
        for pose in 0..poses {
            let own = rays(turn * poses + pose);
            if last.is_none_or(|last| !std::ptr::eq(last, own)) {
                contestant.set_rays(own, tracing);
            }
            last = Some(own);
            let start = Instant::now();
            let update = contestant.frame(pose)?;
            let total = start.elapsed().as_secs_f64();
            times.seconds += total;
            times.total_us.push(1e6 * total);
            times.update_us.push(1e6 * update.as_secs_f64());
        }
        Ok(())
    }
}

#[derive(Default)]
struct Times {
    seconds: f64,
    total_us: Vec<f64>,
    update_us: Vec<f64>,
}

/// Rays whose hit is farther than `error` from the known one, or is none where there is one, or the other way round.
fn wrong_distances(rays: &[Ray], distances: &[f32], known: &[Option<Hit>], error: f64) -> usize {
    let wrong = |((ray, distance), hit): ((&Ray, &f32), &Option<Hit>)| match hit {
        None => distance.is_finite(),
        Some(hit) => {
            let length = ray.direction.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let off = (f64::from(*distance) - f64::from(hit.t)).abs() * length;
            // A NaN is wrong.
            off.is_nan() || off > error
        }
    };
    rays.iter().zip(distances).zip(known).filter(|row| wrong(*row)).count()
}
