use super::key_track::KeyTrack;
use crate::BakeError;
use rayon::prelude::*;
use restpose_formats::rows::KeyVertexRow;

/// Where a vertex's positions are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Home {
    /// On the lattice of a cluster's track.
    Cluster(u32),
    /// As they are in the source.
    Raw,
}

/// Positions of all vertices at the keys of a segment, as the file has them.
pub(crate) struct StoredPositions {
    /// Step of each cluster's lattice, whose zero is the origin of local space.
    pub steps: Vec<f32>,
    /// Per vertex; `track` counts clusters, with their number for the track without keys. `word_first` counts from
    /// `words`.
    pub rows: Vec<KeyVertexRow>,
    /// Without the closing words.
    pub words: Vec<u32>,
    /// Greatest distance between a stored position and the source's, in the cache's space, rounding included.
    pub error: f64,
    /// Greatest magnitude that enters a position when it is decoded.
    pub reach: f64,
}

/// One vertex's part of [`StoredPositions`].
struct Encoded {
    row: KeyVertexRow,
    words: Vec<u32>,
    error: f64,
    reach: f64,
}

/// 2⁻⁴⁸: rounding of a decoded position in `f64`, relative to the magnitudes that enter it.
const F64_ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

impl StoredPositions {
    /// Stores positions on lattices so fine that no vertex is off by more than `budget` at any key, in the cache's units;
    /// with a budget of 0, and wherever a lattice does not reach or does not pay, as they are.
    ///
    /// `frames` has one position per vertex for each key of the segment, `homes` one per vertex.
    pub(crate) fn new<F: AsRef<[[f32; 3]]> + Sync>(
        frames: &[F],
        tracks: &[KeyTrack],
        homes: &[Home],
        budget: f64,
    ) -> Result<Self, BakeError> {
        let steps: Vec<f32> = tracks.iter().map(|track| lattice_step(track, budget)).collect();
        let encoded: Vec<Encoded> = homes
            .par_iter()
            .enumerate()
            .map(|(vertex, home)| {
                let positions = frames.iter().map(|frame| frame.as_ref()[vertex]);
                let on_lattice = match home {
                    Home::Cluster(cluster) if budget > 0.0 => {
                        let (track, step) = (&tracks[*cluster as usize], steps[*cluster as usize]);
                        on_lattice(*cluster, positions.clone(), track, step, budget)
                    }
                    _ => None,
                };
                on_lattice.unwrap_or_else(|| as_it_is(tracks.len() as u32, positions))
            })
            .collect();
        let mut out = Self {
            steps,
            rows: Vec::with_capacity(homes.len()),
            words: Vec::new(),
            error: 0.0,
            reach: 0.0,
        };
        for mut vertex in encoded {
            vertex.row.word_first = crate::assemble::row_count("key words", out.words.len())?;
            out.rows.push(vertex.row);
            out.words.extend(vertex.words);
            out.error = out.error.max(vertex.error);
            out.reach = out.reach.max(vertex.reach);
        }
        Ok(out)
    }

    /// True when some vertex is stored as it is in the source.
    pub(crate) fn has_raw(&self) -> bool {
        self.rows.iter().any(|row| row.raw != 0)
    }

    /// A vertex's stored position at a key in the cache's space, in `f64` from the numbers that the runtime uses.
    pub(crate) fn position<T: std::borrow::Borrow<KeyTrack>>(
        &self,
        tracks: &[T],
        vertex: usize,
        key: usize,
    ) -> [f64; 3] {
        let row = &self.rows[vertex];
        let stored = stored(row, &self.words, key);
        match tracks.get(row.track as usize) {
            Some(track) => lattice_point(track.borrow(), key, f64::from(self.steps[row.track as usize]), stored),
            None => stored,
        }
    }
}

/// [`KeyVertexRow::stored`] on words that are not closed yet.
fn stored(row: &KeyVertexRow, words: &[u32], key: usize) -> [f64; 3] {
    let first = row.word_first as usize + key * row.record_bits() as usize / 32;
    let window: [u32; 3] = std::array::from_fn(|k| words.get(first + k).copied().unwrap_or(0));
    let bit = key as u64 * u64::from(row.record_bits()) % 32;
    let row = KeyVertexRow { word_first: 0, ..*row };
    if row.raw != 0 {
        return window.map(|word| f64::from(f32::from_bits(word)));
    }
    let mut record = (0..3).fold(0u128, |all, k| all | u128::from(window[k]) << (32 * k)) >> bit;
    std::array::from_fn(|k| {
        let number = (record & ((1 << row.widths[k]) - 1)) as i64;
        record >>= row.widths[k];
        (i64::from(row.base[k]) + number) as f64
    })
}

/// A lattice point in the cache's space.
fn lattice_point(track: &KeyTrack, key: usize, step: f64, coordinates: [f64; 3]) -> [f64; 3] {
    let c = track.maps()[key].columns.map(|column| column.map(f64::from));
    let q = coordinates.map(|x| x * step);
    std::array::from_fn(|k| c[0][k] * q[0] + c[1][k] * q[1] + c[2][k] * q[2] + c[3][k])
}

/// The largest step with which rounding moves no point by more than `budget`: half a step along each axis, enlarged by
/// the track's greatest stretch. Zero where nothing that is an `f32` above zero would do.
fn lattice_step(track: &KeyTrack, budget: f64) -> f32 {
    let stretch = track.maps().iter().fold(0.0, |most, map| {
        let linear = glam::DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| map.columns[j].map(f64::from)));
        f64::max(most, greatest_stretch(linear))
    });
    let step = 2.0 * budget / (3f64.sqrt() * stretch);
    // A sixteenth is kept for the rounding of the map itself.
    let step = (step * (1.0 - 1.0 / 16.0)) as f32;
    if step.is_normal() { step } else { 0.0 }
}

/// Bounds the spectral norm: of A, the root of the greatest row sum of AᵀA, after squaring it twice.
fn greatest_stretch(linear: glam::DMat3) -> f64 {
    let mut power = linear.transpose() * linear;
    let scale = power.to_cols_array().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    power *= 1.0 / scale;
    let power = power * power;
    let power = power * power;
    let rows = power
        .to_cols_array_2d()
        .map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
    // Eighth root of a bound of σ⁸.
    (rows.into_iter().fold(0.0, f64::max).sqrt().sqrt() * scale).sqrt()
}

/// A vertex whose positions are the source's. `track` is the one without keys.
fn as_it_is(track: u32, positions: impl Iterator<Item = [f32; 3]>) -> Encoded {
    let words: Vec<u32> = positions.flatten().map(f32::to_bits).collect();
    let reach = words
        .iter()
        .fold(0.0f64, |far, word| far.max(f64::from(f32::from_bits(*word).abs())));
    let row = KeyVertexRow {
        base: [0; 3],
        track,
        word_first: 0,
        widths: [0; 3],
        raw: 1,
    };
    Encoded {
        row,
        words,
        error: 0.0,
        reach,
    }
}

/// A vertex on its lattice, unless it lies beyond that, needs too many bits or misses the budget.
fn on_lattice(
    cluster: u32,
    positions: impl Iterator<Item = [f32; 3]> + Clone,
    track: &KeyTrack,
    step: f32,
    budget: f64,
) -> Option<Encoded> {
    if step == 0.0 {
        return None;
    }
    let step = f64::from(step);
    let limit = f64::from(KeyVertexRow::MAX_COORDINATE);
    let mut coordinates: Vec<[i32; 3]> = Vec::with_capacity(positions.size_hint().0);
    let (mut error, mut reach) = (0.0f64, 0.0f64);
    for (key, position) in positions.enumerate() {
        let position = position.map(f64::from);
        let local = track.local(key, position);
        let rounded = local.map(|x| (x / step).round());
        // A NaN fails the comparison.
        if !rounded.iter().all(|x| x.abs() <= limit) {
            return None;
        }
        let decoded = lattice_point(track, key, step, rounded);
        let mut square = 0.0;
        for k in 0..3 {
            let magnitudes: f64 = track.maps()[key].columns[..3]
                .iter()
                .zip(rounded)
                .map(|(column, x)| f64::from(column[k].abs()) * x.abs() * step)
                .sum();
            let magnitudes = magnitudes + f64::from(track.maps()[key].columns[3][k].abs()) + position[k].abs();
            reach = reach.max(magnitudes);
            let off = (decoded[k] - position[k]).abs() + F64_ROUNDING * magnitudes;
            square += off * off;
        }
        error = error.max(square.sqrt());
        coordinates.push(rounded.map(|x| x as i32));
    }
    let least = |k: usize| coordinates.iter().map(|c| c[k]).min().unwrap_or(0);
    let base = [least(0), least(1), least(2)];
    let widths: [u8; 3] = std::array::from_fn(|k| {
        let most = coordinates.iter().map(|c| c[k]).max().unwrap_or(0);
        (32 - (most - base[k]).leading_zeros()) as u8
    });
    let fits = (0..3).all(|k| {
        widths[k] <= KeyVertexRow::MAX_WIDTH
            && i64::from(base[k]) + (1i64 << widths[k]) - 1 <= i64::from(KeyVertexRow::MAX_COORDINATE)
    });
    if !fits || error.is_nan() || error > budget {
        return None;
    }
    let row = KeyVertexRow {
        base,
        track: cluster,
        word_first: 0,
        widths,
        raw: 0,
    };
    Some(Encoded {
        row,
        words: pack(&row, &coordinates),
        error,
        reach,
    })
}

/// The records of one vertex, low bits first.
fn pack(row: &KeyVertexRow, coordinates: &[[i32; 3]]) -> Vec<u32> {
    let mut words = Vec::with_capacity(row.word_count(coordinates.len() as u32) as usize);
    let (mut pending, mut bits) = (0u128, 0);
    for point in coordinates {
        for k in 0..3 {
            pending |= ((point[k] - row.base[k]) as u128) << bits;
            bits += u32::from(row.widths[k]);
        }
        while bits >= 32 {
            words.push(pending as u32);
            pending >>= 32;
            bits -= 32;
        }
    }
    if bits > 0 {
        words.push(pending as u32);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::geom::Affine;

    fn tracks(keys: usize) -> Vec<KeyTrack> {
        let map = |key: usize, scale: f32| Affine {
            columns: [
                [0.0, scale, 0.0],
                [-scale, 0.0, 0.0],
                [0.0, 0.0, 1.5],
                [key as f32, 2.0, -1.0],
            ],
        };
        vec![
            KeyTrack::new(&(0..keys).map(|key| map(key, 1.0)).collect::<Vec<_>>()),
            KeyTrack::new(&(0..keys).map(|key| map(key, 40.0)).collect::<Vec<_>>()),
        ]
    }

    fn frames(keys: usize, vertices: usize) -> Vec<Vec<[f32; 3]>> {
        let mut random = fastrand::Rng::with_seed(3);
        let mut point = || std::array::from_fn(|_| random.f32() * 6.0 - 3.0);
        (0..keys).map(|_| (0..vertices).map(|_| point()).collect()).collect()
    }

    #[test]
    fn stored_positions_keep_the_budget_and_it_bounds_the_true_error() {
        let (frames, tracks) = (frames(9, 50), tracks(9));
        let homes: Vec<Home> = (0..50).map(|vertex| Home::Cluster(vertex % 2)).collect();
        for budget in [1e-1, 1e-3, 1e-4] {
            let stored = StoredPositions::new(&frames, &tracks, &homes, budget).unwrap();
            assert!(!stored.has_raw() && stored.error <= budget && stored.error > 0.2 * budget);
            let mut greatest = 0.0f64;
            for (key, frame) in frames.iter().enumerate() {
                for (vertex, position) in frame.iter().enumerate() {
                    let found = stored.position(&tracks, vertex, key);
                    let off = glam::DVec3::from(found).distance(glam::DVec3::from(position.map(f64::from)));
                    greatest = greatest.max(off);
                }
            }
            assert!(greatest <= stored.error, "{greatest} > {}", stored.error);
        }
    }

    #[test]
    fn finer_budgets_take_more_words_and_no_budget_is_exact() {
        let (frames, tracks) = (frames(20, 10), tracks(20));
        let homes = vec![Home::Cluster(0); 10];
        let words = |budget| {
            StoredPositions::new(&frames, &tracks, &homes, budget)
                .unwrap()
                .words
                .len()
        };
        assert!(words(1e-1) < words(1e-3) && words(1e-3) < words(0.0));
        let exact = StoredPositions::new(&frames, &tracks, &homes, 0.0).unwrap();
        assert_eq!((exact.words.len(), exact.error), (20 * 10 * 3, 0.0));
        assert_eq!(exact.position(&tracks, 7, 13), frames[13][7].map(f64::from));
    }

    #[test]
    fn what_no_lattice_reaches_is_stored_as_it_is() {
        let tracks = tracks(2);
        let frames = [
            vec![[1e20f32, 0.0, 0.0], [1.0, 2.0, 3.0]],
            vec![[0.0; 3], [1.0, 2.0, 3.5]],
        ];
        let stored = StoredPositions::new(&frames, &tracks, &[Home::Cluster(0); 2], 1e-4).unwrap();
        assert_eq!((stored.rows[0].raw, stored.rows[1].raw), (1, 0));
        assert_eq!(stored.position(&tracks, 0, 0)[0], f64::from(1e20f32));
    }

    #[test]
    fn what_does_not_move_in_its_cluster_takes_no_words() {
        let tracks = tracks(30);
        let point = |key: usize| tracks[0].maps()[key].transform_point([1.0, 2.0, 3.0]);
        let frames: Vec<Vec<[f32; 3]>> = (0..30).map(|key| vec![point(key)]).collect();
        let stored = StoredPositions::new(&frames, &tracks, &[Home::Cluster(0)], 1e-3).unwrap();
        assert!(stored.words.is_empty(), "{:?}", stored.rows[0].widths);
    }
}
