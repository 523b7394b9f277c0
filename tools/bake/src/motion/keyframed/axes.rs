use super::{
    fit::Map,
    fuzzy::FaceScale,
    jacobi::eigen_of_covariance,
    members::Members,
    refine::Refined,
    states::{LANES, States},
    tracks::Track,
};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Tangents of the angles by which axes are turned in search of better ones, each tried about every axis both ways:
/// from 22 to 3 degrees. Smaller turns move the corners of a box by less than its fuzz.
const TURNS: [f64; 4] = [0.4, 0.2, 0.1, 0.05];

/// Turns the local axes of each cluster to the principal axes of its fuzzy positions where its fuzzy boxes cost less
/// that way; with `search`, goes on from there in small turns as long as the cost falls. Says which were turned.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.3.5. Differs: the small turns.
pub(super) fn turn_axes(states: &States, refined: &mut Refined, search: bool) -> Vec<bool> {
    let clusters = Members::of_clusters(states, &refined.cluster_of, refined.tracks.len());
    let turns: Vec<(DMat3, f64)> = clusters
        .par_iter()
        .zip(&refined.tracks)
        .map(|(members, track)| best_turn(states, members, track, search))
        .collect();
    for (track, (turn, gain)) in refined.tracks.iter_mut().zip(&turns) {
        if *gain > 0.0 {
            *track = turned(track, *turn);
            refined.cost -= gain;
        }
    }
    turns.iter().map(|(_, gain)| *gain > 0.0).collect()
}

/// The best rotation of local space, and how much it lowers the cost.
fn best_turn(states: &States, members: &Members, track: &Track, search: bool) -> (DMat3, f64) {
    let before = cost(states, members, track);
    let mut best = (DMat3::IDENTITY, before);
    let mut consider = |turn: DMat3| {
        let cost = cost(states, members, &turned(track, turn));
        let better = cost < best.1;
        if better {
            best = (turn, cost);
        }
        (better, best.0)
    };
    let (_, mut turn) = consider(principal_axes(states, members, track).transpose());
    for tangent in TURNS.into_iter().filter(|_| search) {
        for axis in 0..3 {
            for tangent in [tangent, -tangent] {
                let (better, at) = consider(about_axis(axis, tangent) * turn);
                turn = at;
                if better {
                    break;
                }
            }
        }
    }
    (best.0, before - best.1)
}

fn about_axis(axis: usize, tangent: f64) -> DMat3 {
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turn = DMat3::IDENTITY;
    turn.col_mut(i)[i] = cosine;
    turn.col_mut(j)[j] = cosine;
    turn.col_mut(i)[j] = cosine * tangent;
    turn.col_mut(j)[i] = -cosine * tangent;
    turn
}

fn turned(track: &Track, turn: DMat3) -> Track {
    let turned = |map: &Map| Map {
        linear: turn * map.linear,
        offset: turn * map.offset,
    };
    track.iter().map(turned).collect()
}

/// Cost of a cluster's own fuzzy boxes.
fn cost(states: &States, members: &Members, track: &Track) -> f64 {
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); members.points.len()];
    for (points, boxes) in members.points.chunks(LANES).zip(boxes.chunks_mut(LANES)) {
        for (key, map) in track.iter().enumerate() {
            for (point, (low, high)) in points.iter().zip(boxes.iter_mut()) {
                let p = map.apply(states.position(key, *point as usize));
                for axis in 0..3 {
                    // Plain comparisons become single instructions.
                    low[axis] = if p[axis] < low[axis] { p[axis] } else { low[axis] };
                    high[axis] = if p[axis] > high[axis] { p[axis] } else { high[axis] };
                }
            }
        }
    }
    let scale = FaceScale::new(track);
    let of_triangle = |triangle: &u32| {
        let corners = states.triangles[*triangle as usize];
        let [a, b, c] = corners.map(|corner| boxes[members.points.partition_point(|point| *point < corner)]);
        let sides = a.1.max(b.1).max(c.1) - a.0.min(b.0).min(c.0);
        scale.cost(sides.to_array().map(|side| side as f32))
    };
    members.triangles.iter().map(of_triangle).sum()
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
