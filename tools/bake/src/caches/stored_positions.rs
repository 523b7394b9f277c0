use super::key_track::KeyTrack;
use crate::{BakeError, assemble::row_count};
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
    /// Per vertex; `track` counts clusters, with their number for the track without keys.
    pub rows: Vec<KeyVertexRow>,
    pub words_per_key: u32,
    /// Key by key, and closing ones.
    words: Vec<u32>,
    /// Greatest distance between a stored position and the source's, in the cache's space, rounding included.
    pub error: f64,
    /// Greatest magnitude that enters a position when it is decoded.
    pub reach: f64,
}

/// How one vertex is stored.
struct Encoding {
    /// Its `bit_first` is not known yet.
    row: KeyVertexRow,
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
        let encodings: Vec<Encoding> = homes
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
            words_per_key: 0,
            words: Vec::new(),
            error: 0.0,
            reach: 0.0,
        };
        let mut bits = 0;
        for vertex in encodings {
            let bit_first = row_count("bits of a key's positions", bits)?;
            bits += vertex.row.record_bits() as usize;
            out.rows.push(KeyVertexRow {
                bit_first,
                ..vertex.row
            });
            out.error = out.error.max(vertex.error);
            out.reach = out.reach.max(vertex.reach);
        }
        let per_key = bits.div_ceil(32);
        out.words_per_key = row_count("words of a key's positions", per_key)?;
        row_count("key words", per_key.saturating_mul(frames.len()))?;
        out.words = vec![0; per_key * frames.len() + KeyVertexRow::CLOSING_WORDS];
        if per_key != 0 {
            let words = out.words[..per_key * frames.len()].par_chunks_exact_mut(per_key);
            words.zip(frames).enumerate().for_each(|(key, (words, frame))| {
                pack(words, &out.rows, frame.as_ref(), |cluster, position| {
                    lattice_coordinates(&tracks[cluster], out.steps[cluster], key, position)
                });
            });
        }
        Ok(out)
    }

    /// Without those that close them.
    pub(crate) fn words(&self) -> &[u32] {
        &self.words[..self.words.len() - KeyVertexRow::CLOSING_WORDS]
    }

    /// The words of a key, and all that follow.
    pub(crate) fn key_words(&self, key: usize) -> &[u32] {
        &self.words[key * self.words_per_key as usize..]
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
        let stored = row.stored(self.key_words(key)).map(f64::from);
        match tracks.get(row.track as usize) {
            Some(track) => lattice_point(track.borrow(), key, f64::from(self.steps[row.track as usize]), stored),
            None => stored,
        }
    }
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
fn as_it_is(track: u32, positions: impl Iterator<Item = [f32; 3]>) -> Encoding {
    Encoding {
        row: KeyVertexRow {
            base: [0; 3],
            track,
            bit_first: 0,
            widths: [0; 3],
            raw: 1,
        },
        error: 0.0,
        reach: positions.flatten().fold(0.0, |far, x| f64::max(far, x.abs().into())),
    }
}

/// The point of a track's lattice that is next to a position at a key; not a number where the map has no inverse.
fn lattice_coordinates(track: &KeyTrack, step: f32, key: usize, position: [f32; 3]) -> [f64; 3] {
    let local = track.local(key, position.map(f64::from));
    local.map(|x| (x / f64::from(step)).round())
}

/// A vertex on its lattice, unless it lies beyond that, needs too many bits or misses the budget.
fn on_lattice(
    cluster: u32,
    positions: impl Iterator<Item = [f32; 3]> + Clone,
    track: &KeyTrack,
    step: f32,
    budget: f64,
) -> Option<Encoding> {
    if step == 0.0 {
        return None;
    }
    let limit = f64::from(KeyVertexRow::MAX_COORDINATE);
    let (mut least, mut most) = ([i32::MAX; 3], [i32::MIN; 3]);
    let (mut error, mut reach) = (0.0f64, 0.0f64);
    for (key, position) in positions.enumerate() {
        let rounded = lattice_coordinates(track, step, key, position);
        let (step, position) = (f64::from(step), position.map(f64::from));
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
        for k in 0..3 {
            least[k] = least[k].min(rounded[k] as i32);
            most[k] = most[k].max(rounded[k] as i32);
        }
    }
    let base = least;
    let widths: [u8; 3] = std::array::from_fn(|k| (32 - (most[k] - base[k]).leading_zeros()) as u8);
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
        bit_first: 0,
        widths,
        raw: 0,
    };
    Some(Encoding { row, error, reach })
}

/// Writes the records of one key, low bits first. `coordinates` gives a position's on the lattice of a cluster.
fn pack(
    words: &mut [u32],
    rows: &[KeyVertexRow],
    positions: &[[f32; 3]],
    coordinates: impl Fn(usize, [f32; 3]) -> [f64; 3],
) {
    let mut words = words.iter_mut();
    let (mut pending, mut bits) = (0u64, 0);
    let mut put = |number: u32, width: u32| {
        pending |= u64::from(number) << bits;
        bits += width;
        if bits >= 32 {
            if let Some(word) = words.next() {
                *word = pending as u32;
            }
            pending >>= 32;
            bits -= 32;
        }
    };
    for (row, position) in rows.iter().zip(positions) {
        if row.raw != 0 {
            position.iter().for_each(|x| put(x.to_bits(), 32));
            continue;
        }
        let point = coordinates(row.track as usize, *position);
        for k in 0..3 {
            put((point[k] as i32 - row.base[k]) as u32, row.widths[k].into());
        }
    }
    if let Some(word) = words.next() {
        *word = pending as u32;
    }
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
        let stored = |budget| StoredPositions::new(&frames, &tracks, &homes, budget).unwrap();
        let words = |budget| stored(budget).words().len();
        assert!(words(1e-1) < words(1e-3) && words(1e-3) < words(0.0));
        let exact = stored(0.0);
        assert_eq!((exact.words().len(), exact.error), (20 * 10 * 3, 0.0));
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
        assert!(stored.words().is_empty(), "{:?}", stored.rows[0].widths);
    }
}
