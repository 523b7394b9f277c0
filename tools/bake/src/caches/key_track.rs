use crate::bounds::FuzzyBox;
use restpose_formats::geom::Affine;
use restpose_runtime::invert_frame;
use std::ops::RangeInclusive;

/// Rows of a 3 × 3 matrix.
type Rows = [[f64; 3]; 3];

/// Greatest norm of N (see [`KeyTrack`]), as it is bounded, with which an interval is traced through the tree. It is reached
/// where the cluster frame, on its way from one key to the next, shrinks to about an eighth of the change between them: a turn
/// by more than 150 degrees, say. What the residual does there is then enlarged so much that all boxes would suffer for one
/// interval.
///
/// Tried before: 8, or 125 degrees. A foot of ELEPHANT turns by more in two of 47 intervals, where the first ray to enter its
/// cluster refitted it: with 1.35 million triangles, 100 rays took 3.0 ms there on average and take 0.35 with 16, 1,000 rays
/// 6.9 and 3.3, 10,000 rays 32 and 35; over all intervals 386 and 280 us, 2.67 and 2.53 ms, 25.4 and 26.0 ms. HORSE and CHICKEN
/// are as fast with either.
const MOST_BEND: f64 = 16.0;

/// Parts into which an interval is cut to bound N; a track that needs more bends too much anyway.
const MOST_PARTS: u32 = 64;

/// How far from the middle of a part N may grow before the part is halved, as h·‖N‖. Smaller is tighter and slower.
const PART_GROWTH: f64 = 0.125;

/// 2⁻²⁴: covers the rounding of N in `f64`. From stored maps with a condition number of at most 2¹⁶, E is off by less than
/// 2⁻³⁴, and N by that times (1 + ‖N‖)², of at most (1 + [`MOST_BEND`])².
const BEND_ROUNDING: f64 = 1.0 / (1u64 << 24) as f64;

/// 2⁻⁴⁸: rounding of a fuzzy position in `f64`, relative to the magnitudes that enter it: under 32 roundings of 2⁻⁵³.
const F64_ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// A cluster frame over the keys of a segment, and how to bound fuzzy positions in it for every time between them.
///
/// Between keys the frame is X(s) = (1 − s)·K + s·K′ and a vertex is v(s) = (1 − s)·v + s·v′. With p = K⁻¹v, p′ = K′⁻¹v′
/// and E the linear part of K⁻¹K′ less the identity, X(s)⁻¹v(s) is
///
/// ```text
/// (1 − s)·p + s·p′ + s(1 − s)·N(s)·(p′ − p),   N(s) = (1 + sE)⁻¹E
/// ```
///
/// What does not move in its cluster at the keys does not move between them either, however fast the cluster turns. Tried
/// before: to interpolate the inverses instead, which makes the curve a quadratic with control points K⁻¹v,
/// ½(K⁻¹v′ + K′⁻¹v), K′⁻¹v′. There a mere turn by θ moves a point by up to half of (1 − cos θ) of its distance; bounding
/// the control points made the summed surface of all boxes 4.4 times as large on HORSE, 4.5 on COW, 18 on CHICKEN.
pub(crate) struct KeyTrack {
    maps: Vec<Affine>,
    inverses: Vec<Rows>,
    /// Per interval: bounds |N| entry by entry; `None` where it is cut.
    bends: Vec<Option<Rows>>,
}

impl KeyTrack {
    /// `maps` are the track's maps as stored, each with a usable inverse.
    pub(crate) fn new(maps: &[Affine]) -> Self {
        let mut maps = maps.to_vec();
        let mut inverses = Vec::with_capacity(maps.len());
        for map in &mut maps {
            if invert_frame(map).is_none() {
                *map = Affine::IDENTITY;
            }
            inverses.extend(invert_frame(map));
        }
        let bends = (1..maps.len())
            .map(|key| {
                let mut turn = [[0.0; 3]; 3];
                for (i, row) in turn.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        let column = maps[key].columns[j].map(f64::from);
                        let product: f64 = (0..3).map(|k| inverses[key - 1][i][k] * column[k]).sum();
                        *entry = product - if i == j { 1.0 } else { 0.0 };
                    }
                }
                bend_bound(&turn)
            })
            .collect();
        Self { maps, inverses, bends }
    }

    /// The same track over some of its keys.
    pub(crate) fn over(&self, keys: RangeInclusive<usize>) -> Self {
        let intervals = *keys.start()..*keys.end();
        Self {
            maps: self.maps[keys.clone()].to_vec(),
            inverses: self.inverses[keys].to_vec(),
            bends: self.bends[intervals].to_vec(),
        }
    }

    /// The maps, one per key.
    pub(crate) fn maps(&self) -> &[Affine] {
        &self.maps
    }

    /// True where the tree holds nothing between this key and the next.
    pub(crate) fn is_cut(&self, key: usize) -> bool {
        self.bends.get(key).is_some_and(Option::is_none)
    }

    /// The local position of a point of the cache's space at a key.
    pub(crate) fn local(&self, key: usize, point: [f64; 3]) -> [f64; 3] {
        let translation = self.maps[key].columns[3].map(f64::from);
        let d: [f64; 3] = std::array::from_fn(|k| point[k] - translation[k]);
        self.inverses[key].map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
    }

    /// Bounds how far [`KeyTrack::local`] is from the exact position, for points with |v| ≤ `reach`, together with what two such
    /// errors make of s(1 − s)·|N|·|p′ − p|: half of ‖N‖ as much again.
    pub(crate) fn error(&self, reach: f64) -> f64 {
        self.maps.iter().zip(&self.inverses).fold(0.0, |worst, (map, inverse)| {
            let translation = map.columns[3].iter().fold(0.0f64, |far, x| far.max(f64::from(x.abs())));
            let scale = norm(inverse);
            let local_reach = scale * (reach + translation);
            let error = 2.0 * residual_norm(inverse, map) * local_reach + F64_ROUNDING * local_reach;
            f64::max(worst, error)
        }) * (1.0 + 0.5 * MOST_BEND)
    }

    /// Contains a vertex's fuzzy positions at every time of the segment that is not inside a cut interval. `track` has its
    /// local position at each key.
    pub(crate) fn fuzzy_box(&self, track: &[[f64; 3]]) -> FuzzyBox {
        let mut out = FuzzyBox::EMPTY;
        for point in track {
            out.add(*point);
        }
        for (pair, bend) in track.windows(2).zip(&self.bends) {
            let Some(bend) = bend else {
                continue;
            };
            let (p, q) = (pair[0], pair[1]);
            let step: [f64; 3] = std::array::from_fn(|k| (q[k] - p[k]).abs());
            let over: [f64; 3] = std::array::from_fn(|k| {
                let bent = bend[k][0] * step[0] + bend[k][1] * step[1] + bend[k][2] * step[2];
                overshoot(step[k], bent)
            });
            if over != [0.0; 3] {
                out.add(std::array::from_fn(|k| p[k].min(q[k]) - over[k]));
                out.add(std::array::from_fn(|k| p[k].max(q[k]) + over[k]));
            }
        }
        out
    }

    /// Bounds, per axis, how far a fuzzy position is from the straight line between those at a key and the next, at any time
    /// between them: s(1 − s)·|N|·|p′ − p| is at most a quarter. Nothing where the interval is cut.
    pub(crate) fn bulge(&self, key: usize, from: &[f64; 3], to: &[f64; 3]) -> [f64; 3] {
        let Some(Some(bend)) = self.bends.get(key) else {
            return [0.0; 3];
        };
        let step: [f64; 3] = std::array::from_fn(|k| (to[k] - from[k]).abs());
        bend.map(|row| 0.25 * (row[0] * step[0] + row[1] * step[1] + row[2] * step[2]))
    }
}

/// How far s·step + s(1 − s)·bent leaves [0, step] on either side, for s in [0, 1].
fn overshoot(step: f64, bent: f64) -> f64 {
    if bent > step {
        (bent - step) * ((bent - step) / bent) * 0.25
    } else {
        0.0
    }
}

/// Bounds |N(s)| entry by entry over all s in [0, 1]; `None` where it grows beyond [`MOST_BEND`].
///
/// With N₀ = N(s₀) and h = |s − s₀|, N(s) = (1 + (s − s₀)·N₀)⁻¹N₀, so ‖N(s) − N₀‖ ≤ h·‖N₀‖² / (1 − h·‖N₀‖).
fn bend_bound(turn: &Rows) -> Option<Rows> {
    let mut parts = 1;
    loop {
        match bend_bound_in(turn, parts) {
            Some(bound) => return (norm(&bound) <= MOST_BEND).then_some(bound),
            None if parts >= MOST_PARTS => return None,
            None => parts *= 2,
        }
    }
}

fn bend_bound_in(turn: &Rows, parts: u32) -> Option<Rows> {
    let half = 0.5 / f64::from(parts);
    let mut bound = [[0.0f64; 3]; 3];
    for part in 0..parts {
        let middle = (f64::from(part) + 0.5) / f64::from(parts);
        let bend = bend_at(turn, middle)?;
        let size = norm(&bend);
        if size.is_nan() || half * size > PART_GROWTH {
            return None;
        }
        let growth = half * size * size / (1.0 - half * size);
        for (bound, entry) in bound.iter_mut().flatten().zip(bend.iter().flatten()) {
            *bound = bound.max((entry.abs() + growth) * (1.0 + BEND_ROUNDING) + BEND_ROUNDING);
        }
    }
    Some(bound)
}

/// (1 + sE)⁻¹E.
fn bend_at(turn: &Rows, s: f64) -> Option<Rows> {
    let mut a = turn.map(|row| row.map(|x| s * x));
    for (k, row) in a.iter_mut().enumerate() {
        row[k] += 1.0;
    }
    let cofactor = |i: usize, j: usize| {
        let (r, t) = ((j + 1) % 3, (j + 2) % 3);
        let (c, d) = ((i + 1) % 3, (i + 2) % 3);
        a[r][c] * a[t][d] - a[r][d] * a[t][c]
    };
    let determinant = a[0][0] * cofactor(0, 0) + a[0][1] * cofactor(1, 0) + a[0][2] * cofactor(2, 0);
    if !determinant.is_normal() {
        return None;
    }
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..3).map(|k| cofactor(i, k) / determinant * turn[k][j]).sum())
    }))
}

/// Greatest sum of magnitudes of a row.
fn norm(rows: &Rows) -> f64 {
    rows.iter()
        .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
        .fold(0.0, f64::max)
}

/// `‖B·K − I‖∞` for a computed inverse B, its own rounding included.
fn residual_norm(inverse: &Rows, map: &Affine) -> f64 {
    let columns = [0, 1, 2].map(|j: usize| map.columns[j].map(f64::from));
    inverse.iter().enumerate().fold(0.0, |worst, (k, row)| {
        let sum: f64 = (0..3)
            .map(|j| {
                let products: [f64; 3] = std::array::from_fn(|i| row[i] * columns[j][i]);
                let identity = if j == k { 1.0 } else { 0.0 };
                let rounding = F64_ROUNDING * (products.iter().map(|p| p.abs()).sum::<f64>() + identity);
                (products.iter().sum::<f64>() - identity).abs() + rounding
            })
            .sum();
        f64::max(worst, sum)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    fn affine(linear: DMat3, translation: DVec3) -> Affine {
        let columns = linear.to_cols_array_2d();
        Affine {
            columns: [columns[0], columns[1], columns[2], translation.to_array()].map(|c| c.map(|x| x as f32)),
        }
    }

    fn random_map(random: &mut fastrand::Rng, angle: f64, stretch: f64) -> Affine {
        let mut signed = || random.f64() * 2.0 - 1.0;
        let axis = DVec3::new(signed(), signed(), signed()).normalize();
        let scale = DVec3::new(
            1.0 + stretch * signed(),
            1.0 + stretch * signed(),
            1.0 + stretch * signed(),
        );
        let translation = DVec3::new(signed(), signed(), signed()) * 5.0;
        affine(
            DMat3::from_axis_angle(axis, angle * signed()) * DMat3::from_diagonal(scale),
            translation,
        )
    }

    fn map64(map: &Affine) -> (DMat3, DVec3) {
        let c = map.columns.map(|column| DVec3::from(column.map(f64::from)));
        (DMat3::from_cols(c[0], c[1], c[2]), c[3])
    }

    #[test]
    fn boxes_hold_at_every_time_between_keys() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut tight = 0;
        for round in 0..400 {
            let angle = [0.1, 0.8, 2.0, 3.1][round % 4];
            let maps: Vec<Affine> = (0..3).map(|_| random_map(&mut random, angle, 0.4)).collect();
            let track = KeyTrack::new(&maps);
            let wobble = [0.0, 0.01, 0.5][round % 3];
            let mut signed = |size: f64| (random.f64() * 2.0 - 1.0) * size;
            let rest = DVec3::new(signed(1.0), signed(1.0), signed(1.0));
            let local: Vec<DVec3> = (0..3)
                .map(|_| rest + DVec3::new(signed(wobble), signed(wobble), signed(wobble)))
                .collect();
            let world: Vec<DVec3> = maps
                .iter()
                .zip(&local)
                .map(|(map, p)| {
                    let (linear, translation) = map64(map);
                    linear * *p + translation
                })
                .collect();
            let positions: Vec<[f64; 3]> = world
                .iter()
                .enumerate()
                .map(|(key, v)| track.local(key, v.to_array()))
                .collect();
            let bounds = track.fuzzy_box(&positions).rounded_outwards(track.error(20.0));
            for key in (0..2).filter(|key| !track.is_cut(*key)) {
                tight += 1;
                for step in 0..=64 {
                    let s = f64::from(step) / 64.0;
                    let [(a, b), (c, d)] = [map64(&maps[key]), map64(&maps[key + 1])];
                    let (linear, translation) = (a * (1.0 - s) + c * s, b * (1.0 - s) + d * s);
                    let v = world[key] * (1.0 - s) + world[key + 1] * s;
                    let fuzzy = linear.inverse() * (v - translation);
                    let inside =
                        (0..3).all(|k| f64::from(bounds.min[k]) <= fuzzy[k] && fuzzy[k] <= f64::from(bounds.max[k]));
                    assert!(inside, "round {round} key {key} s {s}: {fuzzy} outside {bounds:?}");
                }
            }
        }
        assert!(tight > 400, "only {tight} intervals were traced through the tree");
    }

    #[test]
    fn rigid_motion_has_no_fuzz_between_keys() {
        let turn = |degrees: f64| {
            affine(
                DMat3::from_rotation_y(degrees.to_radians()),
                DVec3::new(degrees, 0.0, 1.0),
            )
        };
        let track = KeyTrack::new(&[turn(0.0), turn(120.0), turn(60.0)]);
        let point = [1.0, 2.0, 3.0];
        let size = track.fuzzy_box(&[point; 3]).surface_area();
        assert_eq!(size, 0.0);
        assert!(!track.is_cut(0) && !track.is_cut(1) && !track.is_cut(2));
    }

    #[test]
    fn the_bend_is_bounded_between_the_middles_of_its_parts_too() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut bounded = 0;
        for round in 0..2000 {
            let size = [1e-3, 0.1, 0.6, 1.5][round % 4];
            let turn: Rows = std::array::from_fn(|_| std::array::from_fn(|_| (random.f64() * 2.0 - 1.0) * size));
            let Some(bound) = bend_bound(&turn) else {
                continue;
            };
            bounded += 1;
            for step in 0..=256 {
                let bend = bend_at(&turn, f64::from(step) / 256.0).unwrap();
                for (entry, bound) in bend.iter().flatten().zip(bound.iter().flatten()) {
                    assert!(entry.abs() <= *bound, "{turn:?} at {step}/256: {entry} beyond {bound}");
                }
            }
        }
        assert!(bounded > 1000, "only {bounded} turns were bounded");
    }

    #[test]
    fn turns_of_145_degrees_are_not_cut_and_turns_of_160_are() {
        let mut random = fastrand::Rng::with_seed(8);
        for _ in 0..300 {
            let axis = glam::DVec3::from([(); 3].map(|()| random.f64() - 0.5)).normalize_or(glam::DVec3::X);
            let turned = |degrees: f64| {
                let columns = glam::DMat3::from_axis_angle(axis, degrees.to_radians()).to_cols_array_2d();
                let [x, y, z] = columns.map(|column| column.map(|x| x as f32));
                Affine {
                    columns: [x, y, z, [0.0; 3]],
                }
            };
            let track = KeyTrack::new(&[turned(0.0), turned(145.0), turned(-15.0)]);
            assert_eq!([0, 1].map(|key| track.is_cut(key)), [false, true], "about {axis}");
        }
    }

    #[test]
    fn a_half_turn_within_one_interval_is_cut() {
        let turn = |degrees: f64| affine(DMat3::from_rotation_z(degrees.to_radians()), DVec3::ZERO);
        let track = KeyTrack::new(&[turn(0.0), turn(180.0), turn(185.0)]);
        assert!(track.is_cut(0) && !track.is_cut(1));
    }
}
