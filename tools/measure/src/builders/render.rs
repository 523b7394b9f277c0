use super::{
    rays::{primary_rays, random_rays},
    scenes::Triangle,
    settings::BuildersSettings,
    traversal::{Counts, TreeHit, brute_force},
    tree::Tree,
};
use crate::{MeasureError, WrongTreeHit};
use rayon::prelude::*;
use restpose_runtime::Ray;
use std::time::Instant;

/// Triangle tests that comparing one set of rays with brute force takes: a fraction of a second.
const BRUTE_FORCE_TESTS: usize = 20_000_000;

/// Rays that are compared with brute force however many triangles there are.
const FEWEST_BRUTE_FORCE_RAYS: usize = 16;

/// Scenes of more triangles get fewer rays in proportion: a ray costs more there, and there are more trees' worth of it.
const TRIANGLES_OF_ALL_RAYS: usize = 1_000_000;

/// Rays of a turn: a fraction of a millisecond, so that few turns are interrupted on a machine that has other work.
const TURN_RAYS: usize = 256;

/// Rays of one kind through a scene, and what they hit.
pub(super) struct RaySet<'a> {
    triangles: &'a [Triangle],
    rays: Vec<Ray>,
    /// By the tree that came first.
    hits: Vec<Option<TreeHit>>,
    pub brute_force_rays: u64,
}

/// What rays of one kind cost in a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct RenderFigures {
    pub rays: u64,
    pub hit_fraction: f64,
    pub steps: f64,
    pub tests: f64,
    /// One thread.
    pub mrays_per_s: f64,
    /// The reference's time over this tree's, both from the same turns.
    pub relative: f64,
}

/// Camera rays and random rays.
pub(super) fn ray_sets<'a>(triangles: &'a [Triangle], settings: &BuildersSettings) -> [RaySet<'a>; 2] {
    let share = (TRIANGLES_OF_ALL_RAYS as f64 / triangles.len() as f64).min(1.0);
    let side = (f64::from(settings.picture_side) * share.sqrt()).ceil() as u32;
    let random = (f64::from(settings.random_rays) * share).ceil() as u32;
    [
        primary_rays(triangles, side),
        random_rays(triangles, random, settings.seed),
    ]
    .map(|rays| RaySet {
        triangles,
        rays,
        hits: Vec::new(),
        brute_force_rays: 0,
    })
}

impl RaySet<'_> {
    /// Traces all rays by a tree, compares hits, counts and times. Bit for bit: the first tree's hits are compared with
    /// brute force, for a subset, and all others' with the first's. `None` for `reference` if this is the reference.
    pub fn measure(
        &mut self,
        scene: &str,
        builder: &str,
        tree: &Tree,
        reference: Option<&Tree>,
        repeats: u32,
    ) -> Result<RenderFigures, MeasureError> {
        let traced: Vec<(Option<TreeHit>, Counts)> = self
            .rays
            .par_iter()
            .map(|ray| tree.closest_hit(ray, self.triangles))
            .collect();
        let wrong = |ray: usize, found, reference, expected| {
            MeasureError::WrongTreeHit(Box::new(WrongTreeHit {
                scene: scene.to_owned(),
                builder: builder.to_owned(),
                ray: self.rays[ray],
                found,
                reference,
                expected,
            }))
        };
        if self.hits.is_empty() {
            let most = (BRUTE_FORCE_TESTS / self.triangles.len()).max(FEWEST_BRUTE_FORCE_RAYS);
            let step = self.rays.len().div_ceil(most).max(1);
            let subset: Vec<usize> = (0..self.rays.len()).step_by(step).collect();
            let expected: Vec<Option<TreeHit>> = subset
                .par_iter()
                .map(|ray| brute_force(&self.rays[*ray], self.triangles))
                .collect();
            for (ray, expected) in subset.iter().zip(&expected) {
                if traced[*ray].0 != *expected {
                    return Err(wrong(*ray, traced[*ray].0, "brute force", *expected));
                }
            }
            self.brute_force_rays = subset.len() as u64;
            self.hits = traced.iter().map(|(hit, _)| *hit).collect();
        } else if let Some(ray) = (0..self.rays.len()).find(|ray| traced[*ray].0 != self.hits[*ray]) {
            return Err(wrong(ray, traced[ray].0, "the first builder", self.hits[ray]));
        }
        let mut sum = Counts::default();
        traced.iter().for_each(|(_, counts)| sum += *counts);
        let count = self.rays.len() as f64;
        let seconds = self.seconds(std::iter::once(tree).chain(reference), repeats);
        Ok(RenderFigures {
            rays: self.rays.len() as u64,
            hit_fraction: self.hits.iter().flatten().count() as f64 / count,
            steps: sum.steps as f64 / count,
            tests: sum.tests as f64 / count,
            mrays_per_s: count / seconds[0] / 1e6,
            relative: seconds.get(1).map_or(1.0, |reference| reference / seconds[0]),
        })
    }

    /// Seconds that each tree takes for all rays on this thread: trees take turns, and of each turn its least time counts,
    /// because all that disturbs makes it longer. No two trees in a row trace the same rays, unless there are few: branches
    /// are predicted well where a like tree was just traced by them.
    fn seconds<'t>(&self, trees: impl Iterator<Item = &'t Tree>, repeats: u32) -> Vec<f64> {
        let trees: Vec<&Tree> = trees.collect();
        let turns: Vec<&[Ray]> = self.rays.chunks(TURN_RAYS).collect();
        let mut least = vec![vec![f64::INFINITY; turns.len()]; trees.len()];
        for round in 0..=repeats as usize {
            for step in 0..turns.len() {
                for place in 0..trees.len() {
                    let tree = (place + round) % trees.len();
                    let turn = (step + tree * turns.len() / trees.len()) % turns.len();
                    let start = Instant::now();
                    for ray in turns[turn] {
                        std::hint::black_box(trees[tree].closest_hit(ray, self.triangles));
                    }
                    let time = start.elapsed().as_secs_f64();
                    if round > 0 {
                        least[tree][turn] = least[tree][turn].min(time);
                    }
                }
            }
        }
        least.iter().map(|turns| turns.iter().sum()).collect()
    }
}
