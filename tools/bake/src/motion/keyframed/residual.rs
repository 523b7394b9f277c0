//! How far every point is from its rest position in the space of every cluster: the hot loop of the relaxation.

use super::{
    states::{LANES, States},
    tracks::Track,
};
use rayon::prelude::*;

/// Sums over the keys, per point and cluster, of the squared distance of the fuzzy position from the rest position.
///
/// Shape: point, cluster.
pub(super) struct Residuals {
    clusters: usize,
    sums: Vec<f32>,
}

impl Residuals {
    /// Evaluates every point in every cluster and key.
    pub(super) fn new(states: &States, tracks: &[Track], rest_key: usize) -> Self {
        let clusters = tracks.len();
        let maps = key_major(states.keys, tracks);
        let mut sums = vec![0.0f32; states.block_count() * LANES * clusters];
        sums.par_chunks_mut((LANES * clusters).max(1))
            .enumerate()
            .for_each(|(block, out)| {
                let rest = states.rows(block, rest_key);
                let mut rows = vec![[0.0f32; LANES]; clusters];
                for (key, maps) in maps.chunks_exact(clusters).enumerate() {
                    let state = states.rows(block, key);
                    for (map, row) in maps.iter().zip(&mut rows) {
                        add_distances(state, rest, map, row);
                    }
                }
                for (cluster, row) in rows.iter().enumerate() {
                    for (lane, sum) in row.iter().enumerate() {
                        out[lane * clusters + cluster] = *sum;
                    }
                }
            });
        Self { clusters, sums }
    }

    /// The sums of one point, by cluster.
    #[inline]
    fn of_point(&self, point: u32) -> &[f32] {
        &self.sums[point as usize * self.clusters..][..self.clusters]
    }

    /// The cluster where a triangle's residual is smallest, the lowest of equals, and that residual.
    #[inline]
    pub(super) fn best(&self, triangle: [u32; 3]) -> (u32, f32) {
        let [a, b, c] = triangle.map(|point| self.of_point(point));
        let mut best = (0, f32::INFINITY);
        for cluster in 0..self.clusters {
            let sum = a[cluster] + b[cluster] + c[cluster];
            if sum < best.1 {
                best = (cluster as u32, sum);
            }
        }
        best
    }
}

/// The maps of all clusters, key after key: rows of the linear part, each followed by its offset.
pub(super) fn key_major(keys: usize, tracks: &[Track]) -> Vec<[[f32; 4]; 3]> {
    (0..keys)
        .flat_map(|key| {
            tracks.iter().map(move |track| {
                let map = &track[key];
                std::array::from_fn(|k| {
                    let row = map.linear.row(k);
                    [row.x, row.y, row.z, map.offset[k]].map(|x| x as f32)
                })
            })
        })
        .collect()
}

#[inline]
fn add_distances(
    [x, y, z]: [&[f32; LANES]; 3],
    [rx, ry, rz]: [&[f32; LANES]; 3],
    map: &[[f32; 4]; 3],
    sums: &mut [f32; LANES],
) {
    let [[a0, a1, a2, a3], [b0, b1, b2, b3], [c0, c1, c2, c3]] = *map;
    for i in 0..LANES {
        let dx = a0 * x[i] + a1 * y[i] + a2 * z[i] + (a3 - rx[i]);
        let dy = b0 * x[i] + b1 * y[i] + b2 * z[i] + (b3 - ry[i]);
        let dz = c0 * x[i] + c1 * y[i] + c2 * z[i] + (c3 - rz[i]);
        sums[i] += dx * dx + dy * dy + dz * dz;
    }
}
