//! Fuzzy boxes, and what they cost a ray.

use super::{
    residual::key_major,
    states::{LANES, States},
    tracks::Track,
};
use glam::DVec3;
use rayon::prelude::*;

/// Clusters whose boxes of one block are kept together: what a core's first cache holds.
const CLUSTERS_PER_TASK: usize = 4;

/// Least and greatest coordinates of a point's fuzzy positions over all keys.
pub(super) type PointBox = [f32; 6];

const EMPTY: PointBox = [
    f32::INFINITY,
    f32::INFINITY,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NEG_INFINITY,
    f32::NEG_INFINITY,
];

/// Per axis, how a cluster's maps scale a face of a local box that is perpendicular to it, averaged over the keys:
/// normalised area of the parallelogram in the mesh's space per local area.
///
/// With it the cost of a box is the mean over the keys of the surface of what it becomes there, which is what a random
/// ray that meets the mesh meets of it (the surface-area heuristic, in every key). Unlike the box's own surface it does
/// not depend on how large the mesh is in the rest pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceScale(DVec3);

impl FaceScale {
    /// With it the cost of a box is its surface.
    pub(super) const UNIT: Self = Self(DVec3::ONE);

    pub(super) fn new(track: &Track) -> Self {
        let sum = track.iter().fold(DVec3::ZERO, |sum, map| {
            // The cofactors of a map's inverse are its rows over its determinant.
            let rows = map.linear.transpose();
            let determinant = map.linear.determinant();
            sum + DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) / determinant
        });
        Self(sum / track.len().max(1) as f64)
    }

    /// The cost of a box with these sides.
    #[inline]
    pub(super) fn cost(self, sides: [f32; 3]) -> f64 {
        let [x, y, z] = sides.map(f64::from);
        2.0 * (self.0.x * y * z + self.0.y * z * x + self.0.z * x * y)
    }
}

/// Boxes of every point in every cluster.
///
/// Shape: point, cluster.
pub(super) struct PointBoxes {
    clusters: usize,
    boxes: Vec<PointBox>,
}

impl PointBoxes {
    pub(super) fn new(states: &States, tracks: &[Track]) -> Self {
        let clusters = tracks.len();
        let maps = key_major(states.keys, tracks);
        let mut boxes = vec![EMPTY; states.block_count() * LANES * clusters];
        boxes
            .par_chunks_mut((LANES * clusters).max(1))
            .enumerate()
            .for_each(|(block, out)| {
                for first in (0..clusters).step_by(CLUSTERS_PER_TASK) {
                    let count = CLUSTERS_PER_TASK.min(clusters - first);
                    let mut rows = [EMPTY.map(|x| [x; LANES]); CLUSTERS_PER_TASK];
                    for (key, maps) in maps.chunks_exact(clusters).enumerate() {
                        let state = states.rows(block, key);
                        for (map, rows) in maps[first..first + count].iter().zip(&mut rows) {
                            add_positions(state, map, rows);
                        }
                    }
                    for (cluster, rows) in rows[..count].iter().enumerate() {
                        for lane in 0..LANES {
                            out[lane * clusters + first + cluster] = std::array::from_fn(|side| rows[side][lane]);
                        }
                    }
                }
            });
        Self { clusters, boxes }
    }

    /// The box of a point in a cluster.
    #[inline]
    pub(super) fn of_point(&self, point: u32, cluster: usize) -> &PointBox {
        &self.boxes[point as usize * self.clusters + cluster]
    }

    /// The sides of a triangle's fuzzy box in a cluster.
    #[inline]
    pub(super) fn sides(&self, triangle: [u32; 3], cluster: usize) -> [f32; 3] {
        let [a, b, c] = triangle.map(|point| self.of_point(point, cluster));
        std::array::from_fn(|axis| a[axis + 3].max(b[axis + 3]).max(c[axis + 3]) - a[axis].min(b[axis]).min(c[axis]))
    }

    /// The cluster where a triangle's fuzzy box costs least, the lowest of equals, and that cost.
    #[inline]
    pub(super) fn best(&self, triangle: [u32; 3], scales: &[FaceScale]) -> (u32, f64) {
        let mut best = (0, f64::INFINITY);
        for (cluster, scale) in scales.iter().enumerate() {
            let cost = scale.cost(self.sides(triangle, cluster));
            if cost < best.1 {
                best = (cluster as u32, cost);
            }
        }
        best
    }
}

#[inline]
fn add_positions([x, y, z]: [&[f32; LANES]; 3], map: &[[f32; 4]; 3], rows: &mut [[f32; LANES]; 6]) {
    for (axis, [a0, a1, a2, a3]) in map.iter().enumerate() {
        let (low, high) = rows.split_at_mut(3);
        let (low, high) = (&mut low[axis], &mut high[axis]);
        for i in 0..LANES {
            let p = a0 * x[i] + a1 * y[i] + a2 * z[i] + a3;
            low[i] = if p < low[i] { p } else { low[i] };
            high[i] = if p > high[i] { p } else { high[i] };
        }
    }
}
