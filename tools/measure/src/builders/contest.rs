use super::{
    list::{Builder, Threads},
    render::{RaySet, RenderFigures, ray_sets},
    report::BuildFigures,
    scenes::{Triangle, boxes},
    settings::BuildersSettings,
    tree::{Tree, TreeKind, TreeSize},
    worker::Worker,
};
use crate::{MeasureError, peak_memory::peak_while, statistics::median, thread_pools::thread_pools};
use rayon::ThreadPool;
use restpose_bake::Progress;
use restpose_runtime::build::CheckedBoxes;
use std::time::Instant;

/// From this size on memory is measured: what allocators keep of what was freed, tens of megabytes, no longer counts.
const FEWEST_TRIANGLES_FOR_MEMORY: usize = 2_000_000;

/// Triangles in one order.
pub(super) struct Contest<'a> {
    pub scene: &'a str,
    pub triangles: &'a [Triangle],
    pub shuffled: bool,
    pub settings: &'a BuildersSettings,
    pub progress: &'a dyn Progress,
}

/// A builder on so many threads.
struct Contestant<'a> {
    builder: &'a Builder,
    threads: usize,
    /// Place among the pools.
    pool: usize,
    /// Of the build whose tree was examined.
    examined_seconds: f64,
    peak_bytes: Option<u64>,
    first_seconds: Vec<f64>,
    seconds: Vec<f64>,
}

/// What a builder's tree is, on any number of threads.
struct Examined {
    cost: f64,
    size: TreeSize,
    /// Camera rays, random rays.
    render: [RenderFigures; 2],
}

/// Contestants of `builders`.
pub(super) fn contestant_count(builders: &[Builder], settings: &BuildersSettings) -> usize {
    builders
        .iter()
        .map(|builder| thread_counts(builder, settings).len())
        .sum()
}

fn thread_counts(builder: &Builder, settings: &BuildersSettings) -> Vec<usize> {
    match builder.threads {
        Threads::One => vec![1],
        Threads::Any => settings.threads.clone(),
        #[cfg(feature = "peers")]
        Threads::All => vec![std::thread::available_parallelism().map_or(1, usize::from)],
    }
}

impl Contest<'_> {
    /// Rows of all builders, and the rays that were compared with brute force. Trees are validated and their hits compared
    /// before anything is timed; builds are timed in turns.
    pub fn run(&self, builders: &[Builder]) -> Result<(Vec<BuildFigures>, u64), MeasureError> {
        let boxes = boxes(self.triangles);
        let boxes = CheckedBoxes::new(&boxes).map_err(|source| MeasureError::Boxes {
            scene: self.scene.to_owned(),
            source,
        })?;
        let mut counts = self.settings.threads.clone();
        counts.push(1);
        let pools = thread_pools(&counts)?;
        let mut rays = ray_sets(self.triangles, self.settings);
        let mut references: Vec<(TreeKind, Tree)> = Vec::new();
        let mut examined = Vec::with_capacity(builders.len());
        let mut contestants = Vec::new();
        for builder in builders {
            let (own, figures) = self.examine(builder, boxes, &pools, &mut references, &mut rays)?;
            contestants.push(own);
            examined.push(figures);
        }
        drop(references);
        self.time(&mut contestants, boxes, &pools)?;
        let brute_force_rays = rays.iter().map(|rays| rays.brute_force_rays).sum();
        Ok((self.rows(builders, &mut contestants, &examined), brute_force_rays))
    }

    /// Builds on each number of threads; validates every tree, and measures the first.
    fn examine<'b>(
        &self,
        builder: &'b Builder,
        boxes: CheckedBoxes<'_>,
        pools: &[ThreadPool],
        references: &mut Vec<(TreeKind, Tree)>,
        rays: &mut [RaySet; 2],
    ) -> Result<(Vec<Contestant<'b>>, Examined), MeasureError> {
        let mut contestants: Vec<Contestant> = Vec::new();
        let mut first: Option<Tree> = None;
        for threads in thread_counts(builder, self.settings) {
            let pool = self.settings.threads.iter().position(|known| *known == threads);
            // The last pool has one thread.
            let pool = pool.unwrap_or(pools.len() - 1);
            let mut worker = (builder.make)(threads)?;
            worker.prepare(boxes)?;
            let (seconds, peak_bytes) = peak_while(|| timed(worker.as_mut(), boxes, &pools[pool]));
            let tree = worker.take_tree()?;
            drop(worker);
            tree.validate(boxes.get()).map_err(|source| MeasureError::Tree {
                scene: self.scene.to_owned(),
                builder: builder.name.to_owned(),
                threads,
                source,
            })?;
            match &first {
                None => first = Some(tree),
                Some(first) if *first != tree && !builder.is_peer => {
                    return Err(MeasureError::TreeDiffers {
                        scene: self.scene.to_owned(),
                        builder: builder.name.to_owned(),
                        first: contestants[0].threads,
                        threads,
                    });
                }
                Some(_) => {}
            }
            contestants.push(Contestant {
                builder,
                threads,
                pool,
                examined_seconds: seconds?,
                peak_bytes,
                first_seconds: Vec::new(),
                seconds: Vec::new(),
            });
            self.progress.advance(1);
        }
        // The settings have a number of threads at least.
        let tree = first.ok_or(MeasureError::Setting {
            name: "number of thread counts",
            found: 0,
            expected: "1 or more",
        })?;
        let reference = references.iter().find(|(kind, _)| *kind == builder.kind);
        let reference = reference.map(|(_, tree)| tree);
        let render =
            |rays: &mut RaySet| rays.measure(self.scene, builder.name, &tree, reference, self.settings.repeats);
        let examined = Examined {
            cost: tree.sah_cost(),
            size: tree.size(),
            render: [render(&mut rays[0])?, render(&mut rays[1])?],
        };
        if reference.is_none() {
            references.push((builder.kind, tree));
        }
        Ok((contestants, examined))
    }

    /// Times all builds in turns: one of a new builder, then one of the same builder.
    fn time(
        &self,
        contestants: &mut [Vec<Contestant>],
        boxes: CheckedBoxes<'_>,
        pools: &[ThreadPool],
    ) -> Result<(), MeasureError> {
        for round in 0..self.settings.repeats {
            for contestant in contestants.iter_mut().flatten() {
                let spent = 2.0 * contestant.examined_seconds * f64::from(round + 1);
                if spent > self.settings.seconds {
                    continue;
                }
                let pool = &pools[contestant.pool];
                let mut worker = (contestant.builder.make)(contestant.threads)?;
                for times in [&mut contestant.first_seconds, &mut contestant.seconds] {
                    worker.prepare(boxes)?;
                    times.push(timed(worker.as_mut(), boxes, pool)?);
                }
            }
            self.progress.advance(1);
        }
        for contestant in contestants.iter_mut().flatten() {
            if contestant.seconds.is_empty() {
                contestant.first_seconds.push(contestant.examined_seconds);
                contestant.seconds.push(contestant.examined_seconds);
            }
        }
        Ok(())
    }

    fn rows(
        &self,
        builders: &[Builder],
        contestants: &mut [Vec<Contestant>],
        examined: &[Examined],
    ) -> Vec<BuildFigures> {
        let medians: Vec<Vec<[f64; 2]>> = contestants
            .iter_mut()
            .map(|own| {
                let median = |c: &mut Contestant| [median(&mut c.first_seconds), median(&mut c.seconds)];
                own.iter_mut().map(median).collect()
            })
            .collect();
        let triangles = self.triangles.len();
        let mut rows = Vec::new();
        for (place, builder) in builders.iter().enumerate() {
            let reference = builders.iter().position(|other| other.kind == builder.kind);
            let reference = reference.unwrap_or(place);
            let Examined { cost, size, render } = &examined[place];
            let [primary, random] = render;
            for (contestant, [first_seconds, seconds]) in contestants[place].iter().zip(&medians[place]) {
                rows.push(BuildFigures {
                    scene: self.scene.to_owned(),
                    triangles: triangles as u64,
                    shuffled: self.shuffled,
                    tree: builder.kind.name(),
                    builder: builder.name,
                    source: builder.source,
                    peer: builder.is_peer,
                    reference: builders[reference].name,
                    threads: contestant.threads,
                    builds: contestant.seconds.len(),
                    seconds: *seconds,
                    first_seconds: *first_seconds,
                    mtris_per_s: triangles as f64 / seconds / 1e6,
                    speedup: medians[reference][0][1] / seconds,
                    scaling: medians[place][0][1] / seconds,
                    sah_cost: *cost,
                    sah_relative: examined[reference].cost / cost,
                    nodes: size.nodes as u64,
                    references: size.references as u64,
                    depth: size.depth as u64,
                    tree_bytes: size.bytes as u64,
                    peak_bytes_per_triangle: contestant
                        .peak_bytes
                        .filter(|_| triangles >= FEWEST_TRIANGLES_FOR_MEMORY)
                        .map(|bytes| bytes as f64 / triangles as f64),
                    primary_rays: primary.rays,
                    primary_hit_fraction: primary.hit_fraction,
                    primary_steps: primary.steps,
                    primary_tests: primary.tests,
                    primary_mrays_per_s: primary.mrays_per_s,
                    render_relative: primary.relative,
                    random_rays: random.rays,
                    random_hit_fraction: random.hit_fraction,
                    random_steps: random.steps,
                    random_tests: random.tests,
                    random_mrays_per_s: random.mrays_per_s,
                    random_render_relative: random.relative,
                });
            }
        }
        rows
    }
}

/// Seconds of a build.
fn timed(worker: &mut dyn Worker, boxes: CheckedBoxes<'_>, pool: &ThreadPool) -> Result<f64, MeasureError> {
    pool.install(|| {
        let start = Instant::now();
        worker.build(boxes)?;
        Ok(start.elapsed().as_secs_f64())
    })
}
