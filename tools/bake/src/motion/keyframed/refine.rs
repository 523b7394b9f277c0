use super::{
    fit::{Map, Moments, TierCounts},
    fuzzy::{FaceScale, PointBoxes},
    members::Members,
    states::States,
    tracks::{Track, fit_tracks},
};
use glam::DVec3;
use rayon::prelude::*;

/// Part of its box that a point's motion is first asked to keep out of; halved whenever the cost does not fall.
const FIRST_STEP: f64 = 0.2;

/// Steps below this change a box by less than its neighbours do.
const LAST_STEP: f64 = 0.02;

/// Decrease of the cost, relative, below which a step counts as one that did not lower it.
const WORTHWHILE: f64 = 1e-3;

/// Most rounds.
const ROUNDS: usize = 40;

/// Most rounds where the maps were refined before, on a coarser mesh.
const ROUNDS_AGAIN: usize = 4;

/// A clustering by what its fuzzy boxes cost.
#[derive(Clone, Debug, Default)]
pub(super) struct Refined {
    /// Per triangle.
    pub cluster_of: Vec<u32>,
    /// Per cluster.
    pub tracks: Vec<Track>,
    /// Sum of the costs of all fuzzy boxes, square normalised units.
    pub cost: f64,
    /// How the maps were found.
    pub tiers: TierCounts,
}

/// Lowers the cost of the fuzzy boxes, which is what rays pay, starting from the clustering of least squares.
///
/// Each round gives every triangle to the cluster where its fuzzy box costs least, then pulls the maps: every point's
/// fuzzy positions are clamped to its box made a little smaller, and the cluster's maps are fitted to the clamped ones,
/// points of large boxes weighing more. Only a key in which a point reaches the side of its box pulls, so this goes
/// after the largest motion, as the box does, where least squares goes after the mean.
///
/// Here the clamped positions are mapped to the state and the map inverted: their noise is the smaller one, and a fit
/// the other way would shrink the cluster a little in every round.
///
/// Guarantee: the cost is not above that of the start with its triangles given to their best clusters.
pub(super) fn refine(states: &States, tracks: Vec<Track>, tiers: TierCounts) -> Refined {
    let (start, boxes) = by_cost(states, tracks, tiers);
    settle(states, start, boxes, ROUNDS).0
}

/// The same where the maps were refined before, on a coarser mesh.
pub(super) fn settle_again(states: &States, tracks: Vec<Track>, tiers: TierCounts) -> Refined {
    let (start, boxes) = by_cost(states, tracks, tiers);
    settle(states, start, boxes, ROUNDS_AGAIN).0
}

/// The rounds of [`refine`] from what [`by_cost`] found.
pub(super) fn settle(states: &States, start: Refined, boxes: PointBoxes, rounds: usize) -> (Refined, PointBoxes) {
    let (mut best, mut boxes) = (start, boxes);
    let mut step = FIRST_STEP;
    for _ in 0..rounds {
        if step < LAST_STEP || best.cost <= 0.0 {
            break;
        }
        let (tracks, tiers) = pull(states, &best, &boxes, 1.0 - step);
        let (next, next_boxes) = by_cost(states, tracks, tiers);
        if next.cost > best.cost * (1.0 - WORTHWHILE) {
            step *= 0.5;
        }
        if next.cost < best.cost {
            (best, boxes) = (next, next_boxes);
        }
    }
    (best, boxes)
}

/// Gives every triangle to the cluster where its fuzzy box costs least.
pub(super) fn by_cost(states: &States, tracks: Vec<Track>, tiers: TierCounts) -> (Refined, PointBoxes) {
    let boxes = PointBoxes::new(states, &tracks);
    let scales: Vec<FaceScale> = tracks.iter().map(FaceScale::new).collect();
    let (cluster_of, costs): (Vec<u32>, Vec<f64>) = states
        .triangles
        .par_iter()
        .map(|triangle| boxes.best(*triangle, &scales))
        .unzip();
    let cost = costs.iter().sum();
    (
        Refined {
            cluster_of,
            tracks,
            cost,
            tiers,
        },
        boxes,
    )
}

/// A point's box made smaller, as centre and half its sides, and its weight.
struct Goal {
    low: DVec3,
    high: DVec3,
    weight: f64,
}

fn pull(states: &States, from: &Refined, boxes: &PointBoxes, keep: f64) -> (Vec<Track>, TierCounts) {
    let clusters = Members::of_clusters(states, &from.cluster_of, from.tracks.len());
    let goals: Vec<Vec<Goal>> = (0..clusters.len())
        .into_par_iter()
        .map(|cluster| goals(states, &clusters[cluster], cluster, &from.tracks[cluster], boxes, keep))
        .collect();
    let moments = |cluster: usize, key: usize| {
        let members = &clusters[cluster];
        let map = &from.tracks[cluster][key];
        let first = members
            .points
            .first()
            .map_or(DVec3::ZERO, |point| states.position(key, *point as usize));
        let mut moments = Moments::about(map.apply(first), first);
        for (point, goal) in members.points.iter().zip(&goals[cluster]) {
            let state = states.position(key, *point as usize);
            moments.add(goal.weight, map.apply(state).clamp(goal.low, goal.high), state);
        }
        moments
    };
    let first: Vec<_> = from.tracks.iter().map(|track| track[0].linear.inverse()).collect();
    let (mut tracks, tiers) = fit_tracks(states, clusters.len(), 0, &first, moments);
    for ((track, members), old) in tracks.iter_mut().zip(&clusters).zip(&from.tracks) {
        if members.points.is_empty() {
            track.clone_from(old);
            continue;
        }
        for map in track {
            let linear = map.linear.inverse();
            *map = Map {
                linear,
                offset: -(linear * map.offset),
            };
        }
    }
    (tracks, tiers)
}

fn goals(
    states: &States,
    members: &Members,
    cluster: usize,
    track: &Track,
    boxes: &PointBoxes,
    keep: f64,
) -> Vec<Goal> {
    let scale = FaceScale::new(track);
    let mut weights = vec![0.0; members.points.len()];
    for triangle in &members.triangles {
        let corners = states.triangles[*triangle as usize];
        // The cost of a box grows with its sides times what it takes to move them: its size.
        let size = scale.cost(boxes.sides(corners, cluster)).sqrt();
        for corner in corners {
            let place = members.points.partition_point(|point| *point < corner);
            weights[place] += size;
        }
    }
    members
        .points
        .iter()
        .zip(weights)
        .map(|(point, weight)| {
            let [x0, y0, z0, x1, y1, z1] = boxes.of_point(*point, cluster).map(f64::from);
            let (low, high) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
            let (middle, half) = (low * 0.5 + high * 0.5, (high - low) * 0.5 * keep);
            Goal {
                low: middle - half,
                high: middle + half,
                weight,
            }
        })
        .collect()
}
