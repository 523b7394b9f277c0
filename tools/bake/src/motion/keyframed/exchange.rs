use super::{
    fuzzy::{FaceScale, PointBoxes},
    members::Members,
    patch::Neighbours,
    refine::{Refined, by_cost, settle},
    states::States,
    tracks::fit_to_rest,
};
use crate::Progress;
use rayon::prelude::*;

/// Rounds that a moved cluster gets to settle before it is first judged.
const FIRST_ROUNDS: usize = 2;

/// Where the cost is still above the best by this factor then, the move is given up: later rounds gain a few per cent.
const HOPELESS: f64 = 1.1;

/// Further rounds before it is judged for good; by then it has most of its gain.
const MORE_ROUNDS: usize = 3;

/// Clusters, by falling waste, beside which a moved one is tried before the search ends.
const TRIES: usize = 4;

/// Part of a cluster's triangles that a new one begins with.
const SEED_SHARE: usize = 4;

/// Moves clusters to where they are worth more: the one that would be missed least is taken away and put beside the
/// triangle whose fuzzy box wastes most in the cluster that wastes most; kept where the cost falls, until it no longer
/// does or as many were tried as there are clusters. Relaxation alone cannot move a cluster past others that are well placed. `turn` turns local axes to better
/// ones.
///
/// Guarantee: the cost does not rise.
pub(super) fn exchange(
    states: &States,
    mut best: Refined,
    rest_key: usize,
    turn: &mut impl FnMut(&mut Refined),
    progress: &dyn Progress,
) -> Refined {
    let neighbours = Neighbours::new(states.points, &states.triangles);
    let ideals = states.ideal_costs();
    let clusters = best.tracks.len();
    let mut boxes = PointBoxes::new(states, &best.tracks);
    let (mut rank, mut moves) = (0, 0);
    while rank < TRIES.min(clusters.saturating_sub(1)) && moves < clusters {
        moves += 1;
        progress.advance(1);
        let Some((victim, patch)) = choose(states, &neighbours, &best, &boxes, &ideals, rank) else {
            break;
        };
        rank += 1;
        let seed = [Members::of_triangles(states, patch)];
        let mut tracks = best.tracks.clone();
        tracks[victim] = fit_to_rest(states, &seed, rest_key)
            .0
            .into_iter()
            .next()
            .unwrap_or_default();
        let (next, next_boxes) = by_cost(states, tracks, best.tiers);
        let (next, next_boxes) = settle(states, next, next_boxes, FIRST_ROUNDS);
        if next.cost > best.cost * HOPELESS {
            continue;
        }
        let (mut next, _) = settle(states, next, next_boxes, MORE_ROUNDS);
        turn(&mut next);
        if next.cost < best.cost {
            best = next;
            boxes = PointBoxes::new(states, &best.tracks);
            rank = 0;
        }
    }
    best
}

/// The cluster to move, and the triangles where it begins, beside the cluster that wastes most but `rank`.
fn choose(
    states: &States,
    neighbours: &Neighbours,
    from: &Refined,
    boxes: &PointBoxes,
    ideals: &[f64],
    rank: usize,
) -> Option<(usize, Vec<u32>)> {
    let scales: Vec<FaceScale> = from.tracks.iter().map(FaceScale::new).collect();
    let (wastes, losses): (Vec<f64>, Vec<f64>) = (0..states.triangles.len())
        .into_par_iter()
        .map(|triangle| {
            let corners = states.triangles[triangle];
            let own = from.cluster_of[triangle] as usize;
            let cost = scales[own].cost(boxes.sides(corners, own));
            let others = (0..scales.len()).filter(|other| *other != own);
            let second = others.map(|other| scales[other].cost(boxes.sides(corners, other)));
            (cost - ideals[triangle], second.fold(f64::INFINITY, f64::min) - cost)
        })
        .unzip();
    let mut waste = vec![0.0; scales.len()];
    let mut loss = vec![0.0; scales.len()];
    let mut count = vec![0usize; scales.len()];
    for (triangle, cluster) in from.cluster_of.iter().enumerate() {
        waste[*cluster as usize] += wastes[triangle];
        loss[*cluster as usize] += losses[triangle];
        count[*cluster as usize] += 1;
    }
    let mut order: Vec<usize> = (0..scales.len()).collect();
    order.sort_by(|a, b| waste[*b].total_cmp(&waste[*a]).then(a.cmp(b)));
    let target = *order.get(rank)?;
    let victim = (0..scales.len())
        .filter(|cluster| *cluster != target)
        .min_by(|a, b| loss[*a].total_cmp(&loss[*b]))?;
    let own = |triangle: u32| from.cluster_of[triangle as usize] as usize == target;
    let worst = (0..states.triangles.len() as u32)
        .filter(|triangle| own(*triangle))
        .max_by(|a, b| wastes[*a as usize].total_cmp(&wastes[*b as usize]).then(b.cmp(a)))?;
    Some((
        victim,
        neighbours.patch(states, worst, (count[target] / SEED_SHARE).max(12), own),
    ))
}
