use super::{
    fit::TierCounts,
    members::Members,
    residual::Residuals,
    settings::DecomposeSettings,
    states::States,
    tracks::{Track, fit_to_rest},
};
use rayon::prelude::*;

/// RMS residual, in normalised units, at which a clustering counts as exact: the rounding of positions to `f32`, which
/// are at most 1/2, through a map and a difference.
const EXACT: f64 = 1.0 / (1u64 << 23) as f64;

/// A clustering with its maps.
#[derive(Clone, Debug, Default)]
pub(super) struct Clustering {
    /// Per triangle.
    pub cluster_of: Vec<u32>,
    /// Per cluster.
    pub tracks: Vec<Track>,
    /// Per triangle, its squared residual summed over corners and keys, in its cluster.
    pub residuals: Vec<f32>,
    /// Mean square residual over surface and keys, normalised units.
    pub cost: f64,
    /// Iterations that led here.
    pub iterations: usize,
    /// How the maps were found.
    pub tiers: TierCounts,
}

impl Clustering {
    /// True when no clustering can do better.
    pub(super) fn is_exact(&self) -> bool {
        self.cost.sqrt() <= EXACT
    }

    /// Number of clusters.
    pub(super) fn clusters(&self) -> usize {
        self.tracks.len()
    }
}

/// Lloyd relaxation from the maps of some seeds: every triangle goes to the cluster where its residual is smallest, then
/// every cluster's maps are fitted to its triangles, until the residual falls by less than the threshold.
///
/// Guarantee: no cluster is empty unless there are fewer triangles than clusters; the best clustering met is returned.
pub(super) fn relax(states: &States, seeds: Vec<Track>, rest_key: usize, settings: &DecomposeSettings) -> Clustering {
    let mut current = assign(states, seeds, rest_key);
    let mut best: Option<Clustering> = None;
    for iteration in 1..=settings.max_iterations.max(1) {
        let members = Members::of_clusters(states, &current.cluster_of, current.clusters());
        let (tracks, tiers) = fit_to_rest(states, &members, rest_key);
        let next = assign(states, tracks, rest_key);
        let unchanged = next.cluster_of == current.cluster_of;
        current = Clustering {
            iterations: iteration,
            tiers,
            ..next
        };
        let fell = best.as_ref().map_or(f64::INFINITY, |best| best.cost - current.cost);
        let enough = fell > settings.iteration_threshold * current.cost;
        if fell > 0.0 {
            best = Some(current.clone());
        }
        if unchanged || !enough || current.is_exact() {
            break;
        }
    }
    best.unwrap_or(current)
}

/// Gives every triangle to its best cluster; a cluster that would be empty takes the triangle with the largest residual
/// from a cluster that has more than one.
pub(super) fn assign(states: &States, tracks: Vec<Track>, rest_key: usize) -> Clustering {
    let residuals = Residuals::new(states, &tracks, rest_key);
    let (mut cluster_of, residuals): (Vec<u32>, Vec<f32>) = states
        .triangles
        .par_iter()
        .map(|triangle| residuals.best(*triangle))
        .unzip();
    refill_empty(states, &mut cluster_of, &residuals, tracks.len());
    let sum: f64 = states
        .weights
        .iter()
        .zip(&residuals)
        .map(|(weight, sum)| weight * f64::from(*sum))
        .sum();
    Clustering {
        cluster_of,
        tracks,
        residuals,
        cost: sum / (3 * states.keys) as f64,
        iterations: 0,
        tiers: TierCounts::default(),
    }
}

fn refill_empty(states: &States, cluster_of: &mut [u32], residuals: &[f32], clusters: usize) {
    let mut counts = vec![0usize; clusters];
    for cluster in cluster_of.iter() {
        counts[*cluster as usize] += 1;
    }
    for empty in 0..clusters {
        if counts[empty] > 0 {
            continue;
        }
        let weighted = |triangle: usize| states.weights[triangle] * f64::from(residuals[triangle]);
        let taken = (0..cluster_of.len())
            .filter(|triangle| counts[cluster_of[*triangle] as usize] > 1)
            .max_by(|a, b| weighted(*a).total_cmp(&weighted(*b)).then(b.cmp(a)));
        if let Some(triangle) = taken {
            counts[cluster_of[triangle] as usize] -= 1;
            counts[empty] += 1;
            cluster_of[triangle] = empty as u32;
        }
    }
}
