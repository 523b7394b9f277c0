use glam::DVec3;
use rayon::prelude::*;

/// Points that are laid side by side: what a core's first cache holds of accumulators for some thirty clusters.
pub(super) const LANES: usize = 64;

/// Triangles that are to be clustered, with their points in every key, normalised: each key about the centre of its
/// box, all by one scale, so that no coordinate exceeds 1/2 and neither offsets nor units matter.
///
/// Shape of `blocks`: block of [`LANES`] points, key, axis, lane; lanes beyond the last point are zero.
pub(super) struct States {
    pub keys: usize,
    pub points: usize,
    blocks: Vec<f32>,
    /// Per key, what was taken off, in scene units.
    pub centres: Vec<DVec3>,
    /// Scene units per normalised unit.
    pub unit: f64,
    /// Corners, numbered among `points`.
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle, its part of the surface, averaged over the keys; sums to one. Triangles without area weigh a
    /// millionth of the average, so that a cluster made of nothing else still has a place.
    pub weights: Vec<f64>,
}

impl States {
    /// Selects `points` (indices into each key's positions) of `frames`; `triangles` are numbered among `points`.
    pub(super) fn new(frames: &[&[[f32; 3]]], points: &[u32], triangles: Vec<[u32; 3]>) -> Self {
        let boxes: Vec<(DVec3, DVec3)> = frames
            .par_iter()
            .map(|frame| {
                points
                    .iter()
                    .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
                        let v = position(frame, *point);
                        (low.min(v), high.max(v))
                    })
            })
            .collect();
        let widest = boxes
            .iter()
            .map(|(low, high)| (*high - *low).max_element())
            .fold(0.0, f64::max);
        let unit = if widest > 0.0 { widest } else { 1.0 };
        let centres: Vec<DVec3> = boxes
            .iter()
            .map(|(low, high)| {
                if points.is_empty() {
                    DVec3::ZERO
                } else {
                    *low * 0.5 + *high * 0.5
                }
            })
            .collect();
        let keys = frames.len();
        let mut blocks = vec![0.0f32; points.len().div_ceil(LANES) * keys * 3 * LANES];
        blocks
            .par_chunks_mut(keys * 3 * LANES)
            .zip(points.par_chunks(LANES))
            .for_each(|(block, points)| {
                for (key, rows) in block.chunks_exact_mut(3 * LANES).enumerate() {
                    for (lane, point) in points.iter().enumerate() {
                        let v = (position(frames[key], *point) - centres[key]) / unit;
                        for (axis, x) in v.to_array().into_iter().enumerate() {
                            rows[axis * LANES + lane] = x as f32;
                        }
                    }
                }
            });
        let mut states = Self {
            keys,
            points: points.len(),
            blocks,
            centres,
            unit,
            triangles,
            weights: Vec::new(),
        };
        states.weigh();
        states
    }

    /// Some of its points, ascending, under other triangles, which are numbered among these; scale and centres stay.
    pub(super) fn part(&self, points: &[u32], triangles: Vec<[u32; 3]>) -> Self {
        let mut blocks = vec![0.0f32; points.len().div_ceil(LANES) * self.keys * 3 * LANES];
        blocks
            .par_chunks_mut(self.keys * 3 * LANES)
            .zip(points.par_chunks(LANES))
            .for_each(|(block, points)| {
                for (key, rows) in block.chunks_exact_mut(3 * LANES).enumerate() {
                    for (lane, point) in points.iter().enumerate() {
                        let from = self.rows(*point as usize / LANES, key);
                        for (axis, row) in from.into_iter().enumerate() {
                            rows[axis * LANES + lane] = row[*point as usize % LANES];
                        }
                    }
                }
            });
        let mut part = Self {
            keys: self.keys,
            points: points.len(),
            blocks,
            centres: self.centres.clone(),
            unit: self.unit,
            triangles,
            weights: Vec::new(),
        };
        part.weigh();
        part
    }

    fn weigh(&mut self) {
        let sums: Vec<f64> = (0..self.triangles.len())
            .into_par_iter()
            .map(|triangle| (0..self.keys).map(|key| self.area(key, triangle)).sum())
            .collect();
        let total: f64 = sums.iter().sum();
        let count = self.triangles.len() as f64;
        let least = if total > 0.0 { total / count / 1e6 } else { 1.0 };
        let all = total + least * count;
        self.weights = sums.into_iter().map(|sum| (sum + least) / all).collect();
    }

    /// A triangle's area in a key, normalised.
    pub(super) fn area(&self, key: usize, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|point| self.position(key, point as usize));
        0.5 * (b - a).cross(c - a).length()
    }

    /// A point in a key, normalised.
    #[inline]
    pub(super) fn position(&self, key: usize, point: usize) -> DVec3 {
        let row = ((point / LANES) * self.keys + key) * 3 * LANES + point % LANES;
        DVec3::new(
            f64::from(self.blocks[row]),
            f64::from(self.blocks[row + LANES]),
            f64::from(self.blocks[row + 2 * LANES]),
        )
    }

    /// Number of blocks.
    pub(super) fn block_count(&self) -> usize {
        self.points.div_ceil(LANES)
    }

    /// The three rows of [`LANES`] coordinates of a block in a key.
    #[inline]
    pub(super) fn rows(&self, block: usize, key: usize) -> [&[f32; LANES]; 3] {
        let first = (block * self.keys + key) * 3 * LANES;
        let (rows, _) = self.blocks[first..first + 3 * LANES].as_chunks::<LANES>();
        [&rows[0], &rows[1], &rows[2]]
    }

    /// Per triangle, the mean over the keys of the surface of its own box, square normalised units.
    pub(super) fn ideal_costs(&self) -> Vec<f64> {
        let surface = |key: usize, triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|point| self.position(key, point as usize));
            let sides = a.max(b).max(c) - a.min(b).min(c);
            2.0 * (sides.x * sides.y + sides.y * sides.z + sides.z * sides.x)
        };
        let mean = |triangle| (0..self.keys).map(|key| surface(key, triangle)).sum::<f64>() / self.keys as f64;
        self.triangles.par_iter().map(mean).collect()
    }
}

fn position(frame: &[[f32; 3]], point: u32) -> DVec3 {
    DVec3::from_array(frame[point as usize].map(f64::from))
}
