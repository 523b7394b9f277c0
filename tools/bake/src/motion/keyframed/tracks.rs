//! One map per key for each cluster.

use super::{
    fit::{FitModel, Map, Moments, TierCounts},
    members::Members,
    states::States,
};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Keys whose moments one task sums.
const KEYS_PER_TASK: usize = 16;

/// A cluster's maps, one per key: local space from normalised space.
pub(super) type Track = Vec<Map>;

/// Fits every cluster in every key to the points of `rest_key`.
pub(super) fn fit_to_rest(states: &States, clusters: &[Members], rest_key: usize) -> (Vec<Track>, TierCounts) {
    let rests: Vec<Vec<DVec3>> = clusters
        .iter()
        .map(|members| {
            members
                .points
                .iter()
                .map(|point| states.position(rest_key, *point as usize))
                .collect()
        })
        .collect();
    let moments = |cluster: usize, key: usize| {
        let (members, rests) = (&clusters[cluster], &rests[cluster]);
        let first = members.points.first().map_or(0, |point| *point as usize);
        let mut moments = Moments::about(
            states.position(key, first),
            rests.first().copied().unwrap_or(DVec3::ZERO),
        );
        for ((point, weight), rest) in members.points.iter().zip(&members.weights).zip(rests) {
            moments.add(*weight, states.position(key, *point as usize), *rest);
        }
        moments
    };
    fit_tracks(
        states,
        clusters.len(),
        rest_key,
        &vec![DMat3::IDENTITY; clusters.len()],
        moments,
    )
}

/// Fits every cluster in every key from its moments. Fits go outwards from `first_key`, where `first` is the linear part
/// next to it, so that each has a neighbour to agree with where the points leave it open.
pub(super) fn fit_tracks(
    states: &States,
    clusters: usize,
    first_key: usize,
    first: &[DMat3],
    moments: impl Fn(usize, usize) -> Moments + Sync,
) -> (Vec<Track>, TierCounts) {
    let tasks: Vec<(usize, usize)> = (0..clusters)
        .flat_map(|cluster| (0..states.keys).step_by(KEYS_PER_TASK).map(move |key| (cluster, key)))
        .collect();
    let sums: Vec<Vec<Moments>> = tasks
        .into_par_iter()
        .map(|(cluster, key)| {
            (key..states.keys.min(key + KEYS_PER_TASK))
                .map(|key| moments(cluster, key))
                .collect()
        })
        .collect();
    let per_cluster = states.keys.div_ceil(KEYS_PER_TASK);
    let fitted: Vec<(Track, TierCounts)> = sums
        .par_chunks(per_cluster.max(1))
        .zip(first)
        .map(|(sums, first)| {
            let moments: Vec<&Moments> = sums.iter().flatten().collect();
            let mut track = vec![Map::IDENTITY; moments.len()];
            let mut counts = TierCounts::default();
            let mut run = |key: usize, previous: DMat3| {
                let (map, tier) = moments[key].fit(FitModel::Affine, previous);
                counts.count(tier);
                track[key] = map;
                map.linear
            };
            let middle = run(first_key, *first);
            (first_key + 1..moments.len()).fold(middle, |previous, key| run(key, previous));
            (0..first_key).rev().fold(middle, |previous, key| run(key, previous));
            (track, counts)
        })
        .collect();
    let mut counts = TierCounts::default();
    let tracks = fitted
        .into_iter()
        .map(|(track, more)| {
            counts += more;
            track
        })
        .collect();
    (tracks, counts)
}
