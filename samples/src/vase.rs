//! A vase, and the shards that it is made of.

use crate::rotation::{cos_turn, sin_turn};
use crate::surface::Surface;
use fastrand::Rng;
use glam::{DVec2, DVec3};

/// Shards around the vase, and rings of points from the foot to the lip.
const SIDES: usize = 32;
const RINGS: usize = 32;
/// Thickness of the wall and of the bottom, scene units.
const THICKNESS: f64 = 0.03;
const BOTTOM: f64 = 0.012;
/// The outside, as radius and height, from the foot to the lip at about equal distances.
const PROFILE: [[f64; 2]; 10] = [
    [0.18, 0.0],
    [0.16, 0.13],
    [0.26, 0.26],
    [0.36, 0.4],
    [0.4, 0.56],
    [0.37, 0.72],
    [0.28, 0.86],
    [0.17, 0.98],
    [0.13, 1.12],
    [0.2, 1.24],
];
/// How far a point of the cracks lies from its place in an even pattern, in its steps. Below a quarter no shard turns
/// inside out.
const UNEVENNESS: f64 = 0.22;
/// Points lie on a grid of this many steps per scene unit, which keeps their text short.
const GRID: f64 = 10_000.0;

/// A piece of the wall: a triangle of the outside and the one behind it on the inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shard {
    /// Outside, counter-clockwise seen from there; then the points behind these, in the same order. Scene units.
    pub corners: [DVec3; 6],
    /// Numbers that corners of the outside share with those of other shards at the same place.
    places: [usize; 3],
}

impl Shard {
    /// Its five faces, by corner.
    ///
    /// Guarantee: shards that share a side cut it along the same diagonal, where faces become fans about their first
    /// corners.
    pub fn faces(&self) -> [Vec<u32>; 5] {
        let side = |from: usize| {
            let to = (from + 1) % 3;
            let [a, b] = [from as u32, to as u32];
            if self.places[from] < self.places[to] {
                vec![a, a + 3, b + 3, b]
            } else {
                vec![b, a, a + 3, b + 3]
            }
        };
        [vec![0, 1, 2], vec![3, 5, 4], side(0), side(1), side(2)]
    }

    /// Mean of its corners.
    pub fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / 6.0
    }

    /// Unit normal of its outside.
    pub fn outward(&self) -> DVec3 {
        let [a, b, c, ..] = self.corners;
        (b - a).cross(c - a).normalize_or(DVec3::Y)
    }

    /// Its closed surface.
    pub fn surface(&self) -> Surface {
        let fan = |face: Vec<u32>| (2..face.len()).map(move |last| [face[0], face[last - 1], face[last]]);
        Surface {
            positions: self.corners.to_vec(),
            triangles: self.faces().into_iter().flat_map(fan).collect(),
        }
    }
}

/// The shards of a vase that stands on the origin, 1.24 scene units high.
///
/// Guarantee: they fill the wall without gaps or overlaps.
pub fn shards() -> Vec<Shard> {
    let mut rng = Rng::with_seed(32);
    // The middle of the foot, outside and inside; then the rings.
    let mut points = vec![[DVec3::ZERO, DVec3::Y * BOTTOM]];
    for ring in 0..RINGS {
        points.extend((0..SIDES).map(|side| wall_point(ring, side, &mut rng)));
    }
    let at = |ring: usize, side: usize| 1 + ring * SIDES + side % SIDES;
    let mut triangles: Vec<[usize; 3]> = (0..SIDES).map(|side| [0, at(0, side + 1), at(0, side)]).collect();
    for ring in 1..RINGS {
        for side in 0..SIDES {
            let [low, high] = [ring - 1, ring].map(|ring| [at(ring, side), at(ring, side + 1)]);
            triangles.extend(if rng.bool() {
                [[low[0], low[1], high[1]], [low[0], high[1], high[0]]]
            } else {
                [[low[0], low[1], high[0]], [low[1], high[1], high[0]]]
            });
        }
    }
    let shard = |places: [usize; 3]| {
        let [a, b, c] = places.map(|place| points[place]);
        let corners = [a[0], b[0], c[0], a[1], b[1], c[1]];
        Shard { corners, places }
    };
    triangles.into_iter().map(shard).collect()
}

/// A point of the cracks on the outside, and the one behind it on the inside.
fn wall_point(ring: usize, side: usize, rng: &mut Rng) -> [DVec3; 2] {
    let mut uneven = || UNEVENNESS * (2.0 * rng.f64() - 1.0);
    let turn = (side as f64 + uneven()) / SIDES as f64;
    let along = uneven();
    // Foot and lip are even.
    let along = if (1..RINGS - 1).contains(&ring) { along } else { 0.0 };
    let (outside, tangent) = profile((ring as f64 + along) / (RINGS - 1) as f64);
    let inwards = if ring == 0 {
        DVec2::new(-THICKNESS, BOTTOM)
    } else {
        tangent.perp() * THICKNESS
    };
    [outside, outside + inwards].map(|at| {
        let point = DVec3::new(at.x * sin_turn(turn), at.y, at.x * cos_turn(turn));
        (point * GRID).round() / GRID + DVec3::ZERO
    })
}

/// The outside as radius and height at a share of its way from foot to lip, and the unit tangent there.
///
/// A uniform Catmull-Rom spline through [`PROFILE`].
fn profile(share: f64) -> (DVec2, DVec2) {
    let last = PROFILE.len() - 1;
    let place = share * last as f64;
    let span = (place as usize).min(last - 1);
    let key = |number: usize| DVec2::from(PROFILE[number]);
    let (from, to) = (key(span), key(span + 1));
    let before = if span == 0 { 2.0 * from - to } else { key(span - 1) };
    let after = if span + 1 == last {
        2.0 * to - from
    } else {
        key(span + 2)
    };
    let (a, b) = ((to - before) * 0.5, (after - from) * 0.5);
    let [third, second] = [2.0 * (from - to) + a + b, 3.0 * (to - from) - 2.0 * a - b];
    let t = place - span as f64;
    let point = from + t * (a + t * (second + t * third));
    let tangent = a + t * (2.0 * second + t * 3.0 * third);
    (point, tangent.normalize_or(DVec2::Y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn shards_are_closed_and_outward() {
        let shards = shards();
        assert_eq!(shards.len(), 2_016);
        for shard in shards {
            let surface = shard.surface();
            assert!(surface.is_closed_manifold());
            assert!(surface.volume() > 1e-6, "{shard:?}");
        }
    }

    #[test]
    fn shards_fill_the_wall() {
        // Each triangle inside the wall is there twice, once from either side; what is left is the vase's surface.
        let mut left: BTreeMap<[[u64; 3]; 3], i32> = BTreeMap::new();
        let mut whole = Surface::default();
        let mut places: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut volume = 0.0;
        for shard in shards() {
            let surface = shard.surface();
            volume += surface.volume();
            for corners in &surface.triangles {
                let points = corners.map(|corner| surface.positions[corner as usize].to_array().map(f64::to_bits));
                let mut sorted = points;
                sorted.sort_unstable();
                let even = (0..3).any(|first| [0, 1, 2].map(|k| points[(first + k) % 3]) == sorted);
                *left.entry(sorted).or_default() += if even { 1 } else { -1 };
            }
        }
        for (mut points, count) in left.into_iter().filter(|(_, count)| *count != 0) {
            assert_eq!(count.abs(), 1);
            if count < 0 {
                points.swap(0, 1);
            }
            let mut number = |point: [u64; 3]| {
                *places
                    .entry(point)
                    .or_insert_with(|| whole.push(point.map(f64::from_bits).into()))
            };
            let corners = points.map(&mut number);
            whole.triangles.push(corners);
        }
        assert!(whole.is_closed_manifold());
        // Outside and inside, and the lip between them.
        assert_eq!(whole.triangles.len(), 2 * 2_016 + 2 * SIDES);
        // Thousands of sums of parts of one.
        assert!((whole.volume() - volume).abs() < 1e-12, "{} {volume}", whole.volume());
    }

    #[test]
    fn the_profile_meets_its_keys() {
        for (number, key) in PROFILE.iter().enumerate() {
            let (point, tangent) = profile(number as f64 / 9.0);
            // A handful of roundings of numbers up to ten.
            assert!(point.distance(DVec2::from(*key)) < 1e-14, "{number}: {point}");
            assert!((tangent.length() - 1.0).abs() < 1e-15);
        }
    }
}
