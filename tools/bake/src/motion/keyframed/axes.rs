use super::{
    fuzzy::{FaceScale, PointBoxes},
    jacobi::eigen_of_covariance,
    members::Members,
    refine::Refined,
    states::States,
    tracks::Track,
};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Turns the local axes of each cluster to the principal axes of its fuzzy positions where its fuzzy boxes cost less
/// that way; says which were turned.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.3.5.
pub(super) fn turn_axes(states: &States, refined: &mut Refined) -> Vec<bool> {
    let clusters = Members::of_clusters(states, &refined.cluster_of, refined.tracks.len());
    let turns: Vec<DMat3> = clusters
        .par_iter()
        .zip(&refined.tracks)
        .map(|(members, track)| principal_axes(states, members, track).transpose())
        .collect();
    let turned: Vec<Track> = refined
        .tracks
        .iter()
        .zip(&turns)
        .map(|(track, turn)| turn_track(track, *turn))
        .collect();
    let before = costs(states, &clusters, &refined.tracks);
    let after = costs(states, &clusters, &turned);
    let mut kept = vec![false; clusters.len()];
    for (cluster, track) in turned.into_iter().enumerate() {
        if after[cluster] < before[cluster] {
            refined.cost += after[cluster] - before[cluster];
            refined.tracks[cluster] = track;
            kept[cluster] = true;
        }
    }
    kept
}

fn turn_track(track: &Track, turn: DMat3) -> Track {
    track
        .iter()
        .map(|map| super::fit::Map {
            linear: turn * map.linear,
            offset: turn * map.offset,
        })
        .collect()
}

/// Cost of each cluster's own fuzzy boxes.
fn costs(states: &States, clusters: &[Members], tracks: &[Track]) -> Vec<f64> {
    let boxes = PointBoxes::new(states, tracks);
    clusters
        .par_iter()
        .enumerate()
        .map(|(cluster, members)| {
            let scale = FaceScale::new(&tracks[cluster]);
            let cost = |triangle: &u32| scale.cost(boxes.sides(states.triangles[*triangle as usize], cluster));
            members.triangles.iter().map(cost).sum()
        })
        .collect()
}

/// Columns: the axes of the covariance of the fuzzy positions over all keys, points weighted by their triangles.
fn principal_axes(states: &States, members: &Members, track: &Track) -> DMat3 {
    let positions = || {
        track.iter().enumerate().flat_map(|(key, map)| {
            let weighted = members.points.iter().zip(&members.weights);
            weighted.map(move |(point, weight)| (map.apply(states.position(key, *point as usize)), *weight))
        })
    };
    let (sum, total) = positions().fold((DVec3::ZERO, 0.0), |(sum, total), (p, weight)| {
        (sum + p * weight, total + weight)
    });
    let mean = if total > 0.0 { sum / total } else { DVec3::ZERO };
    let mut covariance = DMat3::ZERO;
    for (p, weight) in positions() {
        let (p, wp) = (p - mean, (p - mean) * weight);
        covariance += DMat3::from_cols(wp * p.x, wp * p.y, wp * p.z);
    }
    eigen_of_covariance(covariance).1
}
