//! Scenes of our own, of any size: what the papers' scenes are like, without being them.

mod regular;
mod uneven;

use restpose_runtime::Aabb;
use std::str::FromStr;

/// Corners.
pub(super) type Triangle = [[f32; 3]; 3];

/// A scene that is made, not read.
///
/// Guarantee: the same triangles in every run, exactly as many as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Generated {
    /// What it is like.
    pub kind: GeneratedKind,
    /// Triangles, 1 to [`Generated::MOST_TRIANGLES`].
    pub triangles: usize,
}

/// What a generated scene is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeneratedKind {
    /// A bumpy closed surface as a scanner sees it: triangles of like size and shape, neighbours close in order.
    Regular,
    /// A furnished room: a floor and walls of a few huge triangles, long thin ones, and most of all in small knobs.
    Uneven,
}

impl GeneratedKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Regular, Self::Uneven];

    /// The word on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Regular => "regular",
            Self::Uneven => "uneven",
        }
    }
}

impl Generated {
    /// Most triangles of a generated scene.
    pub const MOST_TRIANGLES: usize = 100_000_000;

    /// Its triangles.
    pub(super) fn triangles(self, seed: u64) -> Vec<Triangle> {
        let mut triangles = Vec::with_capacity(self.triangles);
        let mut sink = Sink {
            triangles: &mut triangles,
            wanted: self.triangles,
        };
        match self.kind {
            GeneratedKind::Regular => regular::generate(self.triangles, seed, &mut sink),
            GeneratedKind::Uneven => uneven::generate(self.triangles, seed, &mut sink),
        }
        triangles
    }
}

impl std::fmt::Display for Generated {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.kind.name(), self.triangles)
    }
}

impl FromStr for Generated {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || {
            format!(
                "expected KIND=TRIANGLES, KIND regular or uneven, TRIANGLES 1 to {}",
                Self::MOST_TRIANGLES
            )
        };
        let (kind, triangles) = text.split_once('=').ok_or_else(form)?;
        let kind = GeneratedKind::ALL.into_iter().find(|known| known.name() == kind);
        match (kind, triangles.parse()) {
            (Some(kind), Ok(triangles @ 1..=Self::MOST_TRIANGLES)) => Ok(Self { kind, triangles }),
            _ => Err(form()),
        }
    }
}

/// Takes triangles until there are as many as wanted.
struct Sink<'a> {
    triangles: &'a mut Vec<Triangle>,
    wanted: usize,
}

impl Sink<'_> {
    fn add(&mut self, triangle: Triangle) {
        if self.left() > 0 {
            self.triangles.push(triangle);
        }
    }

    /// Two triangles, corners in order around them.
    fn quad(&mut self, [a, b, c, d]: [[f32; 3]; 4]) {
        self.add([a, b, c]);
        self.add([a, c, d]);
    }

    /// Triangles that are still wanted.
    fn left(&self) -> usize {
        self.wanted - self.triangles.len()
    }
}

/// Puts triangles into random order.
pub(super) fn shuffle(triangles: &mut [Triangle], seed: u64) {
    fastrand::Rng::with_seed(seed).shuffle(triangles);
}

/// The box of each triangle.
pub(super) fn boxes(triangles: &[Triangle]) -> Vec<Aabb> {
    triangles.iter().map(|corners| Aabb::around(*corners)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn areas(triangles: &[Triangle]) -> Vec<f64> {
        let area = |[a, b, c]: &Triangle| {
            let side = |p: &[f32; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(p[k]) - f64::from(a[k])) };
            let (u, v) = (side(b), side(c));
            let n = (0..3).map(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                (u[i] * v[j] - u[j] * v[i]).powi(2)
            });
            0.5 * n.sum::<f64>().sqrt()
        };
        let mut areas: Vec<f64> = triangles.iter().map(area).collect();
        areas.sort_by(f64::total_cmp);
        areas
    }

    #[test]
    fn counts_are_exact_and_every_run_makes_the_same() {
        for kind in GeneratedKind::ALL {
            for triangles in [1, 2, 17, 18, 19, 100, 999, 12_345] {
                let scene = Generated { kind, triangles };
                let made = scene.triangles(1);
                assert_eq!(made.len(), triangles, "{scene}");
                assert!(made.iter().flatten().flatten().all(|x| x.is_finite()));
                assert_eq!(made, scene.triangles(1));
                assert_eq!(scene.to_string().parse(), Ok(scene));
            }
            let scene = Generated { kind, triangles: 5000 };
            assert_ne!(scene.triangles(1), scene.triangles(2), "{scene}");
        }
    }

    #[test]
    fn regular_triangles_are_alike_and_uneven_ones_are_not() {
        let of = |kind| {
            areas(
                &Generated {
                    kind,
                    triangles: 50_000,
                }
                .triangles(1),
            )
        };
        let (regular, uneven) = (of(GeneratedKind::Regular), of(GeneratedKind::Uneven));
        let at = |areas: &[f64], share: f64| areas[(share * (areas.len() - 1) as f64) as usize];
        assert!(at(&regular, 0.0) > 0.0);
        assert!(at(&regular, 0.95) < 10.0 * at(&regular, 0.05));
        assert!(at(&uneven, 1.0) > 1e5 * at(&uneven, 0.5));
        assert!(at(&uneven, 0.95) > 10.0 * at(&uneven, 0.05));
    }

    #[test]
    fn regular_surfaces_of_an_even_count_are_closed() {
        for triangles in [18, 20, 22, 1000, 1234] {
            let made = Generated {
                kind: GeneratedKind::Regular,
                triangles,
            }
            .triangles(3);
            let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
            for corners in &made {
                for k in 0..3 {
                    let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|p| p.map(f32::to_bits));
                    let (key, way) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
                    *edges.entry(key).or_default() += way;
                }
            }
            assert!(edges.values().all(|ways| *ways == 0), "{triangles}: an edge is open");
            assert_eq!(edges.len() * 2, triangles * 3, "{triangles}");
        }
    }

    #[test]
    fn neighbours_in_order_are_neighbours_in_space_until_shuffled() {
        let scene = Generated {
            kind: GeneratedKind::Regular,
            triangles: 20_000,
        };
        let mut triangles = scene.triangles(1);
        let jumps = |triangles: &[Triangle]| -> f32 {
            let distance = |pair: &[Triangle]| (0..3).map(|k| (pair[0][0][k] - pair[1][0][k]).abs()).sum::<f32>();
            triangles.windows(2).map(distance).sum()
        };
        let ordered = jumps(&triangles);
        shuffle(&mut triangles, 1);
        assert!(jumps(&triangles) > 20.0 * ordered);
        let mut again = scene.triangles(1);
        shuffle(&mut again, 1);
        assert_eq!(triangles, again);
    }

    #[test]
    fn other_words_are_refused() {
        for wrong in [
            "",
            "regular",
            "regular=",
            "regular=0",
            "flat=3",
            "uneven=100000001",
            "uneven=-1",
        ] {
            assert!(wrong.parse::<Generated>().is_err(), "{wrong:?}");
        }
    }
}
