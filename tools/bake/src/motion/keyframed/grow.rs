use super::{
    fuzzy::{FaceScale, PointBoxes},
    members::Members,
    patch::Neighbours,
    relax::{Clustering, relax},
    report::{GrowthStep, StopReason},
    rest::best_rest,
    settings::DecomposeSettings,
    states::States,
    tracks::{Track, fit_to_rest},
};
use crate::Progress;
use std::time::Instant;

/// Triangles of a seed: one and those around it, so that they span a coordinate system.
const SEED_TRIANGLES: usize = 12;

/// Clusters over which the decrease of the residual is judged: one alone may bring little before the next brings much.
pub(super) const PATIENCE: usize = 3;

/// Numbers of clusters at which the rest pose is chosen anew; it is chosen once more at the end.
const REST_AT: [usize; 3] = [1, 4, 16];

/// What growing the number of clusters found.
pub(super) struct Grown {
    pub clustering: Clustering,
    pub rest_key: usize,
    pub rest_candidates: usize,
    pub steps: Vec<GrowthStep>,
    pub stop: StopReason,
    /// Seconds spent on searches for the rest pose.
    pub rest_seconds: f64,
}

/// Algorithm 1 of the thesis: relaxes one cluster, then adds one at a time.
///
/// A new cluster begins with the triangle of the largest residual and those around it; the existing ones begin again
/// with their triangle of the smallest residual and those around it.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.3.2.
pub(super) fn grow(states: &States, most: usize, settings: &DecomposeSettings, progress: &dyn Progress) -> Grown {
    let neighbours = Neighbours::new(states.points, &states.triangles);
    let everything = Members::of_clusters(states, &vec![0; states.triangles.len()], 1);
    let mut search = RestSearch {
        key: 0,
        candidates: 0,
        seconds: 0.0,
    };
    search.run(states, &everything, settings);
    let mut current = relax(
        states,
        fit_to_rest(states, &everything, search.key).0,
        search.key,
        settings,
    );
    let mut steps = vec![step(states, &current)];
    let stop = loop {
        progress.advance(1);
        let clusters = current.clusters();
        if let Some(reason) = stop_reason(states, &current, &steps, most, settings) {
            break reason;
        }
        if clusters > 1 && REST_AT.contains(&clusters) {
            current = search.again(states, current, settings);
        }
        let seeds = seeds(states, &neighbours, &current, search.key);
        current = relax(states, seeds, search.key, settings);
        steps.push(step(states, &current));
    };
    if current.clusters() > 1 {
        current = search.again(states, current, settings);
    }
    Grown {
        clustering: current,
        rest_key: search.key,
        rest_candidates: search.candidates,
        steps,
        stop,
        rest_seconds: search.seconds,
    }
}

fn stop_reason(
    states: &States,
    current: &Clustering,
    steps: &[GrowthStep],
    most: usize,
    settings: &DecomposeSettings,
) -> Option<StopReason> {
    if current.is_exact() {
        return Some(StopReason::Exact);
    }
    if current.clusters() >= most {
        return Some(StopReason::MostClusters);
    }
    if current.clusters() >= states.triangles.len() {
        return Some(StopReason::MostTriangles);
    }
    let [.., earlier, _, _, last] = steps else { return None };
    let fell = 1.0 - last.residual / earlier.residual;
    (fell < settings.cluster_threshold * PATIENCE as f64).then_some(StopReason::Converged)
}

/// The rest pose and what looking for it took.
struct RestSearch {
    key: usize,
    candidates: usize,
    seconds: f64,
}

impl RestSearch {
    /// Looks for the best rest pose of some clusters; true when it is another one.
    fn run(&mut self, states: &States, clusters: &[Members], settings: &DecomposeSettings) -> bool {
        let begin = Instant::now();
        let (key, candidates) = best_rest(states, clusters, settings.rest_step);
        self.seconds += begin.elapsed().as_secs_f64();
        self.candidates = candidates;
        std::mem::replace(&mut self.key, key) != key
    }

    /// Chooses the rest pose anew for a clustering and relaxes it there if it is another one.
    fn again(&mut self, states: &States, current: Clustering, settings: &DecomposeSettings) -> Clustering {
        let members = Members::of_clusters(states, &current.cluster_of, current.clusters());
        if !self.run(states, &members, settings) {
            return current;
        }
        relax(states, fit_to_rest(states, &members, self.key).0, self.key, settings)
    }
}

fn step(states: &States, clustering: &Clustering) -> GrowthStep {
    let boxes = PointBoxes::new(states, &clustering.tracks);
    let scales: Vec<FaceScale> = clustering.tracks.iter().map(FaceScale::new).collect();
    let (mut area, mut cost) = (0.0, 0.0);
    for (triangle, cluster) in states.triangles.iter().zip(&clustering.cluster_of) {
        let sides = boxes.sides(*triangle, *cluster as usize);
        area += FaceScale::UNIT.cost(sides);
        cost += scales[*cluster as usize].cost(sides);
    }
    GrowthStep {
        clusters: clustering.clusters(),
        residual: clustering.cost.sqrt() * states.unit,
        fuzzy_box_area: area * states.unit * states.unit,
        cost: cost * states.unit * states.unit,
        iterations: clustering.iterations,
    }
}

/// Maps of the seeds of one cluster more.
fn seeds(states: &States, neighbours: &Neighbours, current: &Clustering, rest_key: usize) -> Vec<Track> {
    let residual = |triangle: u32| current.residuals[triangle as usize];
    let mut closest: Vec<Option<u32>> = vec![None; current.clusters()];
    let mut farthest = 0u32;
    for (triangle, cluster) in current.cluster_of.iter().enumerate() {
        let triangle = triangle as u32;
        let least = &mut closest[*cluster as usize];
        if least.is_none_or(|least| residual(triangle) < residual(least)) {
            *least = Some(triangle);
        }
        if residual(triangle) > residual(farthest) {
            farthest = triangle;
        }
    }
    let mut patches: Vec<Members> = closest
        .iter()
        .enumerate()
        .map(|(cluster, least)| {
            let own = |triangle: u32| current.cluster_of[triangle as usize] == cluster as u32;
            let patch = least.map(|least| neighbours.patch(states, least, SEED_TRIANGLES, own));
            Members::of_triangles(states, patch.unwrap_or_default())
        })
        .collect();
    let patch = neighbours.patch(states, farthest, SEED_TRIANGLES, |_| true);
    patches.push(Members::of_triangles(states, patch));
    fit_to_rest(states, &patches, rest_key).0
}
