//! Which key makes the best rest pose: all pairs of keys, from moments.

use super::{members::Members, states::States};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Keys on a side of a tile of pairs.
const TILE: usize = 16;

/// Coordinates of the keys of a tile.
const COLUMNS: usize = 3 * TILE;

/// Points whose coordinates are gathered at a time: a first cache holds them for two tiles.
const POINTS: usize = 64;

/// Floating-point operations that one search may cost, some seconds on one core. Where all candidates would cost more,
/// every n-th is tried; 400 keys of 5,000 points cost an eighth of it.
const WORK_LIMIT: u64 = 1 << 34;

/// Added to each variance relative to their sum: the rounding of coordinates to `f32`, squared with room for sums.
const VARIANCE_ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

type Panel = Vec<[f64; COLUMNS]>;

/// The key whose points, as rest pose, leave the smallest residual when every cluster is mapped to it from every key by
/// unlimited affine least squares; and how many keys were tried.
///
/// Exact: the residual of fitting key t to candidate t' is tr C(t',t') - tr(C(t',t) C(t,t)⁻¹ C(t,t')) with the cluster's
/// 3 × 3 covariances C, so all pairs are one product of the matrix of all coordinates with itself. It is taken tile by
/// tile and never stored: memory does not grow with the square of the keys.
///
/// A residual is measured in the candidate's own units, where a key in which the mesh is small would look good: each
/// cluster's is therefore divided by its surface in the candidate and multiplied by its mean surface. (The thesis does
/// not.)
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, Eq. 3.3.
pub(super) fn best_rest(states: &States, clusters: &[Members], step: usize) -> (usize, usize) {
    let candidates = candidates(states, clusters, step.max(1));
    let costs = costs(states, clusters, &candidates);
    let best = costs
        .iter()
        .zip(&candidates)
        .min_by(|a, b| a.0.total_cmp(b.0).then(a.1.cmp(b.1)));
    (best.map_or(0, |(_, key)| *key), candidates.len())
}

fn candidates(states: &States, clusters: &[Members], step: usize) -> Vec<usize> {
    let points: usize = clusters.iter().map(|members| members.points.len()).sum();
    let per_pair = 18 * points as u64 + 100 * clusters.len() as u64;
    let most = WORK_LIMIT / per_pair.max(1) / states.keys.max(1) as u64;
    let step = step.max(states.keys.div_ceil(usize::try_from(most).unwrap_or(usize::MAX).max(1)));
    (0..states.keys).step_by(step).collect()
}

/// What the pairs need to know of a cluster.
struct Spread {
    /// Per key: weighted mean, covariance's trace, inverse of the covariance.
    keys: Vec<(DVec3, f64, DMat3)>,
    /// Per key: mean surface over the surface in that key.
    growth: Vec<f64>,
}

fn spread(states: &States, members: &Members) -> Spread {
    let total: f64 = members.weights.iter().sum();
    let keys = (0..states.keys)
        .map(|key| {
            let points = || {
                members
                    .points
                    .iter()
                    .map(|point| states.position(key, *point as usize))
                    .zip(&members.weights)
            };
            let mean = points().map(|(v, weight)| v * *weight).sum::<DVec3>() / total;
            let mut covariance = DMat3::ZERO;
            for (v, weight) in points() {
                let (v, wv) = (v - mean, (v - mean) * *weight);
                covariance += DMat3::from_cols(wv * v.x, wv * v.y, wv * v.z);
            }
            let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
            let inverse = (covariance + DMat3::from_diagonal(DVec3::splat(trace * VARIANCE_ROUNDING))).inverse();
            (mean, trace, if inverse.is_finite() { inverse } else { DMat3::ZERO })
        })
        .collect();
    let areas: Vec<f64> = (0..states.keys)
        .map(|key| {
            members
                .triangles
                .iter()
                .map(|triangle| states.area(key, *triangle as usize))
                .sum()
        })
        .collect();
    let mean = areas.iter().sum::<f64>() / states.keys as f64;
    // A candidate without surface in a cluster is as bad as one shrunk a millionfold.
    let growth = areas
        .iter()
        .map(|area| if mean > 0.0 { mean / area.max(mean / 1e6) } else { 1.0 })
        .collect();
    Spread { keys, growth }
}

fn costs(states: &States, clusters: &[Members], candidates: &[usize]) -> Vec<f64> {
    let spreads: Vec<Spread> = clusters.par_iter().map(|members| spread(states, members)).collect();
    let all: Vec<usize> = (0..states.keys).collect();
    // With every key a candidate a tile serves both ways round.
    let symmetric = candidates.len() == all.len();
    let tasks: Vec<(usize, usize)> = (0..all.len().div_ceil(TILE))
        .flat_map(|rows| (0..candidates.len().div_ceil(TILE)).map(move |columns| (rows, columns)))
        .filter(|(rows, columns)| !symmetric || rows <= columns)
        .collect();
    let sums: Vec<[[f64; TILE]; 2]> = tasks
        .par_iter()
        .map(|(rows, columns)| {
            let rows_keys = &all[rows * TILE..all.len().min((rows + 1) * TILE)];
            let column_keys = &candidates[columns * TILE..candidates.len().min((columns + 1) * TILE)];
            let both = symmetric && rows != columns;
            let mut out = [[0.0; TILE]; 2];
            for (members, spread) in clusters
                .iter()
                .zip(&spreads)
                .filter(|(members, _)| !members.points.is_empty())
            {
                let product = covariances(states, members, spread, rows_keys, column_keys);
                add_residuals(spread, &product, rows_keys, column_keys, both, &mut out);
            }
            out
        })
        .collect();
    let mut costs = vec![0.0; candidates.len()];
    for ((rows, columns), [by_column, by_row]) in tasks.iter().zip(&sums) {
        for (cost, sum) in costs[columns * TILE..].iter_mut().zip(by_column) {
            *cost += sum;
        }
        if symmetric && rows != columns {
            for (cost, sum) in costs[rows * TILE..].iter_mut().zip(by_row) {
                *cost += sum;
            }
        }
    }
    costs
}

/// Σ w (v - v̄)(v' - v̄')ᵀ of all pairs of keys: coordinate of the first, coordinate of the second.
fn covariances(states: &States, members: &Members, spread: &Spread, rows: &[usize], columns: &[usize]) -> Panel {
    let mut out = vec![[0.0; COLUMNS]; COLUMNS];
    let mut left: Panel = vec![[0.0; COLUMNS]; POINTS];
    let mut right = left.clone();
    for (points, weights) in members.points.chunks(POINTS).zip(members.weights.chunks(POINTS)) {
        gather(states, spread, points, rows, &mut left);
        gather(states, spread, points, columns, &mut right);
        for (row, weight) in left.iter_mut().zip(weights) {
            row.iter_mut().for_each(|x| *x *= weight);
        }
        multiply(&left[..points.len()], &right[..points.len()], &mut out);
    }
    out
}

fn gather(states: &States, spread: &Spread, points: &[u32], keys: &[usize], panel: &mut Panel) {
    for (place, key) in keys.iter().enumerate() {
        let mean = spread.keys[*key].0;
        for (row, point) in panel.iter_mut().zip(points) {
            let v = states.position(*key, *point as usize) - mean;
            row[3 * place..3 * place + 3].copy_from_slice(&v.to_array());
        }
    }
}

/// `out += leftᵀ · right`, in squares of four that stay in registers.
fn multiply(left: &[[f64; COLUMNS]], right: &[[f64; COLUMNS]], out: &mut Panel) {
    for i in (0..COLUMNS).step_by(4) {
        for j in (0..COLUMNS).step_by(4) {
            let mut square = [[0.0f64; 4]; 4];
            for (a, b) in left.iter().zip(right) {
                let b: [f64; 4] = std::array::from_fn(|k| b[j + k]);
                for (row, sums) in square.iter_mut().enumerate() {
                    for k in 0..4 {
                        sums[k] += a[i + row] * b[k];
                    }
                }
            }
            for (row, sums) in square.iter().enumerate() {
                for k in 0..4 {
                    out[i + row][j + k] += sums[k];
                }
            }
        }
    }
}

/// Adds, per column key as rest pose, the residuals of the row keys; with `both`, also the other way round.
fn add_residuals(
    spread: &Spread,
    product: &Panel,
    rows: &[usize],
    columns: &[usize],
    both: bool,
    out: &mut [[f64; TILE]; 2],
) {
    for (i, row) in rows.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            // Covariance of row and column key, transposed: columns are coordinates of the row key.
            let block: [DVec3; 3] =
                std::array::from_fn(|axis| DVec3::from_slice(&product[3 * i + axis][3 * j..3 * j + 3]));
            let block = DMat3::from_cols(block[0], block[1], block[2]);
            let residual = |state: usize, rest: usize, cross: DMat3| {
                let fitted = cross * spread.keys[state].2 * cross.transpose();
                let fitted = fitted.x_axis.x + fitted.y_axis.y + fitted.z_axis.z;
                (spread.keys[rest].1 - fitted).max(0.0) * spread.growth[rest]
            };
            out[0][j] += residual(*row, *column, block);
            if both {
                out[1][i] += residual(*column, *row, block.transpose());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::keyframed::{fit::FitModel, fit::Moments};

    #[test]
    fn costs_are_those_of_fitting_every_pair() {
        let mut random = fastrand::Rng::with_seed(4);
        // More keys than a tile, more points than a panel.
        let (keys, points) = (TILE + 5, POINTS + 9);
        let base: Vec<DVec3> = (0..points)
            .map(|_| DVec3::from_array(std::array::from_fn(|_| random.f64())))
            .collect();
        let frames: Vec<Vec<[f32; 3]>> = (0..keys)
            .map(|key| {
                let size = 1.0 + (key % 3) as f64;
                let mut noise = || DVec3::from_array(std::array::from_fn(|_| random.f64() * 0.1));
                base.iter()
                    .map(|v| ((*v + noise()) * size).as_vec3().to_array())
                    .collect()
            })
            .collect();
        let frames: Vec<&[[f32; 3]]> = frames.iter().map(Vec::as_slice).collect();
        let all: Vec<u32> = (0..points as u32).collect();
        let triangles = (0..points as u32 - 2).map(|k| [k, k + 1, k + 2]).collect();
        let states = States::new(&frames, &all, triangles);
        let half = states.triangles.len() / 2;
        let cluster_of: Vec<u32> = (0..states.triangles.len()).map(|t| u32::from(t < half)).collect();
        let clusters = Members::of_clusters(&states, &cluster_of, 2);
        let direct = |rest: usize| -> f64 {
            let of_cluster = |members: &Members| -> f64 {
                let growth = spread(&states, members).growth[rest];
                let residual = |key: usize| {
                    let mut moments = Moments::about(DVec3::ZERO, DVec3::ZERO);
                    let points = || members.points.iter().map(|p| *p as usize).zip(&members.weights);
                    points().for_each(|(p, w)| moments.add(*w, states.position(key, p), states.position(rest, p)));
                    let (map, _) = moments.fit(FitModel::Affine, DMat3::IDENTITY);
                    let off =
                        |p: usize| (map.apply(states.position(key, p)) - states.position(rest, p)).length_squared();
                    points().map(|(p, w)| w * off(p)).sum::<f64>()
                };
                (0..keys).map(residual).sum::<f64>() * growth
            };
            clusters.iter().map(of_cluster).sum()
        };
        for candidates in [(0..keys).collect::<Vec<_>>(), (0..keys).step_by(2).collect()] {
            let costs = costs(&states, &clusters, &candidates);
            for (cost, rest) in costs.iter().zip(&candidates) {
                let expected = direct(*rest);
                // Differences of covariances in f64; both are about a hundredth of them.
                assert!(
                    (cost - expected).abs() <= 1e-9 * expected,
                    "rest {rest}: {cost} {expected}"
                );
            }
        }
    }
}
