use crate::view::View;
use restpose_runtime::{Aabb, Ray};
use serde::Serialize;
use std::str::FromStr;

/// Pixels of a tile's side: rays of a picture come tile by tile, so that neighbours are coherent.
pub(super) const TILE: u32 = 8;

/// How much nearer the close-up is.
const ZOOM: f64 = 3.0;

/// Where rays run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayKind {
    /// From one point of the scene's box through another.
    Random,
    /// From one point of the scene's box to another, no farther: line of sight.
    Segment,
    /// A square picture of the whole scene.
    Primary,
    /// A square picture of the scene's middle, three times as large.
    CloseUp,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Random, Self::Segment, Self::Primary, Self::CloseUp];

    /// As in tables and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Segment => "segment",
            Self::Primary => "primary",
            Self::CloseUp => "close-up",
        }
    }

    /// Whether neighbours run almost alike.
    pub(super) fn is_coherent(self) -> bool {
        matches!(self, Self::Primary | Self::CloseUp)
    }
}

impl FromStr for RayKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(Self::name).join(", ");
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == text);
        kind.ok_or_else(|| format!("no kind of rays {text:?}; known: {}", known()))
    }
}

/// Rays of one kind and number.
pub(super) struct RaySet {
    pub kind: RayKind,
    /// Rays of a frame.
    pub count: usize,
    /// As many, or more, which frames take in turns.
    rays: Vec<Ray>,
}

impl RaySet {
    /// `bounds` are those of the scene; `most` is how many rays there are to take turns.
    pub(super) fn new(kind: RayKind, count: u32, most: u32, bounds: &Aabb, seed: u64) -> Self {
        let rays = match kind {
            RayKind::Random => random(most.max(count), bounds, seed, |from, to| {
                Ray::new(from, std::array::from_fn(|k| to[k] - from[k]))
            }),
            RayKind::Segment => random(most.max(count), bounds, seed, Ray::between),
            RayKind::Primary => View::of(bounds).tiled_rays(picture_side(count), TILE),
            RayKind::CloseUp => View::of(bounds).magnified(ZOOM).tiled_rays(picture_side(count), TILE),
        };
        let count = if kind.is_coherent() { rays.len() } else { count as usize };
        Self { kind, count, rays }
    }

    /// Those of a frame: with few rays a frame, each frame has others.
    pub(super) fn of_frame(&self, frame: usize) -> &[Ray] {
        let starts = self.rays.len() - self.count + 1;
        let start = frame.wrapping_mul(self.count) % starts;
        &self.rays[start..start + self.count]
    }
}

/// The side of a picture of whole tiles that has about `count` pixels.
pub(super) fn picture_side(count: u32) -> u32 {
    let tiles = (f64::from(count).sqrt() / f64::from(TILE)).round() as u32;
    tiles.max(1) * TILE
}

fn random(count: u32, bounds: &Aabb, seed: u64, ray: fn([f32; 3], [f32; 3]) -> Ray) -> Vec<Ray> {
    let mut numbers = fastrand::Rng::with_seed(seed);
    let mut point = || std::array::from_fn(|k| bounds.min[k] + numbers.f32() * (bounds.max[k] - bounds.min[k]));
    (0..count)
        .map(|_| {
            let from = point();
            ray(from, point())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Aabb = Aabb {
        min: [-1.0, 0.0, 2.0],
        max: [1.0, 3.0, 2.5],
    };

    #[test]
    fn frames_with_few_rays_take_turns() {
        let set = RaySet::new(RayKind::Random, 3, 10, &BOX, 7);
        assert_eq!((set.rays.len(), set.of_frame(0).len()), (10, 3));
        assert_eq!(set.of_frame(0), &set.rays[..3]);
        assert_eq!(set.of_frame(2), &set.rays[6..9]);
        assert_eq!(set.of_frame(3), &set.rays[1..4], "9 is 1 beyond the last start");
        assert_eq!(RaySet::new(RayKind::Random, 10, 10, &BOX, 7).of_frame(5).len(), 10);
    }

    #[test]
    fn random_rays_run_inside_the_box_and_segments_end_there() {
        for kind in [RayKind::Random, RayKind::Segment] {
            for ray in RaySet::new(kind, 100, 100, &BOX, 1).of_frame(0) {
                let to: [f32; 3] = std::array::from_fn(|k| ray.origin[k] + ray.direction[k]);
                for point in [ray.origin, to] {
                    // The end is a sum of rounded numbers below 4.
                    assert!((0..3).all(|k| point[k] >= BOX.min[k] - 1e-6 && point[k] <= BOX.max[k] + 1e-6));
                }
                assert_eq!(ray.t_max.is_finite(), kind == RayKind::Segment);
            }
        }
    }

    #[test]
    fn pictures_have_whole_tiles() {
        for (count, side) in [(1, 8), (100, 8), (1_000, 32), (10_000, 104), (1_000_000, 1_000)] {
            assert_eq!(picture_side(count), side);
        }
        assert_eq!(RaySet::new(RayKind::Primary, 1_000, 5, &BOX, 1).count, 1_024);
    }

    #[test]
    fn kinds_have_names() {
        for kind in RayKind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
        }
        assert!("sideways".parse::<RayKind>().is_err());
    }
}
