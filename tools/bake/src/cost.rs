//! What rays and frames are expected to cost: how the baker compares structures before it has traced a ray.

use restpose_formats::geom::Aabb;
use restpose_runtime::build::{BvhSettings, KdSettings};

/// Fuzzy trees are built with the builder's own constants. A test poses three vertices first, so one could think it worth
/// more steps than the 1.5 of a tree over posed triangles; but a leaf tests each triangle's own box before.
///
/// Measured on CHICKEN in 8 segments, primary rays, intersection costs of 4, 2 and 1.2: 16.0, 14.0 and 13.0 steps, 2.4,
/// 2.6 and 2.8 tests, 14.1, 11.6 and 9.5 MB; the times lie within their noise.
pub(crate) fn fuzzy_tree() -> KdSettings {
    KdSettings::default()
}

/// What wide trees are compared by: a test of eight boxes takes about as long as a step through a kd-tree (15 to 20 ns), posing
/// and testing a triangle of which little is remembered three times that (`restpose measure frame`, single rays).
pub(crate) fn wide_tree() -> BvhSettings {
    BvhSettings {
        traversal_cost: 1.0,
        intersection_cost: 3.0,
    }
}

/// What a node with boxes at keys is compared by: its boxes are interpolated, and read in two more places. Files with such boxes
/// and without take times in proportion to their expected costs where it is 1.2 (elephant), 2.1 (horse) and 3.5 (cow).
pub(crate) const KEYED_TRAVERSAL_COST: f64 = 2.0;

// Not counted: that the runtime poses and refits the whole of an instance that many rays enter, which takes a twentieth of the time
// of building and traces as fast: ns a ray in the whole and in the rebuilt tree, cow 377 and 352, horse 343 and 338, ELEPHANT 418
// and 420, the shattering vase 554 and 500. Since the constants below were measured, rebuilding has come down from their 420 ns a
// triangle to 300, the wide tree included, and its rays from 28.5 ns a unit of cost to 16.5. They stay: with the new ones the choice
// would turn at 7,000 rays for the cow, where the whole takes 2.7 ms and rebuilding 4.2.

/// Steps that it takes to bring a ray into a cluster: the top level's share and the ray's transformation.
const ENTRY_COST: f64 = 8.0;

/// The expected steps of a ray that meets the box around all clusters, mean over the key frames.
///
/// `clusters` are expected costs of trees with the box of their contents at each key; the chance to enter one is the ratio of
/// surfaces.
pub(crate) fn expected_cost<'a>(clusters: impl Iterator<Item = (f64, &'a [Aabb])> + Clone) -> f64 {
    let key_count = clusters.clone().map(|(_, bounds)| bounds.len()).max().unwrap_or(0);
    let mut wholes = vec![Aabb::EMPTY; key_count];
    for (key, bounds) in clusters.clone().flat_map(|(_, bounds)| bounds.iter().enumerate()) {
        wholes[key] = wholes[key].union(*bounds);
    }
    let mut cost = 0.0;
    for (tree, bounds) in clusters {
        let inside = ENTRY_COST + tree;
        let shares = bounds.iter().zip(&wholes).map(|(own, whole)| share(own, whole));
        cost += inside * shares.sum::<f64>();
    }
    cost / key_count.max(1) as f64
}

/// The chance that a ray that meets `whole` meets `own`, which lies inside.
fn share(own: &Aabb, whole: &Aabb) -> f64 {
    let ratio = own.surface_area() / whole.surface_area();
    if ratio.is_finite() { ratio } else { 1.0 }
}

/// Nanoseconds of a ray per unit of [`expected_cost`].
///
/// This constant and the next three were measured together, the ways in turns on one loaded core by its processor time, so
/// that their ratios hold rather than they: 10,000 uniformly random lines that meet the box, closest hits, in 8 poses each.
/// Cow 1,851 ns for a cost of 93, horse 1,304 for 68, chicken 1,557 for 81: 19 to 20. Elephant 3,216 for 119: 27, as it
/// leaves the caches, which meets hierarchies alike. Where boxes are much wider than what moves, fewer: 8 to 13 in the
/// bundled shards.
const FUZZY_NANOSECONDS: f64 = 19.5;

/// Nanoseconds of a ray per unit of the cost of a hierarchy over posed triangles, Eq. 4.1 with constants of 1: cow 618 ns for
/// 21.0, horse 590 for 20.6, chicken 621 for 23.5: 26 to 30. Elephant 1,215 for 29.7: 41.
const REBUILT_NANOSECONDS: f64 = 28.5;

/// Nanoseconds per triangle of posing it and building that hierarchy, on one thread: cow 451, horse 366, chicken 388,
/// elephant 575, goose 521, shards 345.
const REBUILD_NANOSECONDS: f64 = 420.0;

/// Nanoseconds per cluster of interpolating its track, bounding it, and posing it for the first ray: beside 20 µs of a frame
/// that both ways have, cow 48 µs for 44 clusters, horse 35 for 33, chicken 28 for 39, shatter 100 for 52; half as much again
/// where rays enter all of them.
const CLUSTER_NANOSECONDS: f64 = 1_500.0;

/// What a part is expected to take one thread per frame, and per ray that meets it.
#[derive(Clone, Copy, Debug, Default)]
struct Nanoseconds {
    frame: f64,
    ray: f64,
}

impl Nanoseconds {
    fn milliseconds(self, rays: f64) -> f64 {
        // Rays are counted up to the largest number.
        ((self.frame + self.ray * rays) / 1e6).min(f64::MAX)
    }
}

/// Fuzzy trees as [`structure_cost`] sees them.
pub(crate) struct FuzzyTrees {
    /// [`expected_cost`].
    pub cost: f64,
    /// Clusters of a frame.
    pub clusters: f64,
    /// Triangles of a frame for which a hierarchy is built nonetheless, because their clusters turn over or collapse.
    pub rebuilt_triangles: f64,
}

/// The two ways to trace a part: fuzzy trees, or a hierarchy built in every frame.
///
/// All on one thread.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StructureCost {
    fuzzy: Nanoseconds,
    rebuilt: Nanoseconds,
}

impl StructureCost {
    /// `rebuilt` is the expected cost of the hierarchy, Eq. 4.1, over all `triangles` of the part.
    pub(crate) fn new(fuzzy: &FuzzyTrees, rebuilt: f64, triangles: usize) -> Self {
        Self {
            fuzzy: Nanoseconds {
                frame: fuzzy.clusters * CLUSTER_NANOSECONDS + fuzzy.rebuilt_triangles * REBUILD_NANOSECONDS,
                ray: fuzzy.cost * FUZZY_NANOSECONDS,
            },
            rebuilt: Nanoseconds {
                frame: triangles as f64 * REBUILD_NANOSECONDS,
                ray: rebuilt * REBUILT_NANOSECONDS,
            },
        }
    }

    /// Whether a frame of `rays` is expected to be cheaper with a hierarchy built for it; never without rays. Turns at most
    /// once as `rays` above zero grow.
    pub(crate) fn is_free(&self, rays: f64) -> bool {
        rays > 0.0 && (self.fuzzy.ray - self.rebuilt.ray) * rays > self.rebuilt.frame - self.fuzzy.frame
    }

    /// Rays of a frame at which both ways cost the same; `None` where one is cheaper for any number.
    pub(crate) fn even_rays(&self) -> Option<f64> {
        let rays = (self.rebuilt.frame - self.fuzzy.frame) / (self.fuzzy.ray - self.rebuilt.ray);
        (rays.is_finite() && rays > 0.0).then_some(rays)
    }

    /// Milliseconds of a frame of `rays` on one thread, with fuzzy trees.
    pub(crate) fn fuzzy_milliseconds(&self, rays: f64) -> f64 {
        self.fuzzy.milliseconds(rays)
    }

    /// The same with a hierarchy built for it.
    pub(crate) fn rebuilt_milliseconds(&self, rays: f64) -> f64 {
        self.rebuilt.milliseconds(rays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(fuzzy: f64, clusters: f64, rebuilt: f64, triangles: usize) -> StructureCost {
        let fuzzy = FuzzyTrees {
            cost: fuzzy,
            clusters,
            rebuilt_triangles: 0.0,
        };
        StructureCost::new(&fuzzy, rebuilt, triangles)
    }

    /// Costs that the baker found for real motion, and the number of rays at which both ways took as long when measured.
    #[test]
    fn the_turn_is_where_it_was_measured() {
        for (name, costs, measured) in [
            ("cow", costs(93.2, 44.0, 21.0, 5_804), 2_009.0),
            ("horse", costs(67.9, 33.0, 20.6, 16_843), 8_508.0),
            ("chicken", costs(80.9, 33.0, 23.5, 5_664), 2_222.0),
            ("elephant", costs(119.2, 37.0, 29.7, 84_638), 24_255.0),
            ("shards", costs(605.6, 50.0, 54.3, 16_128), 804.0),
        ] {
            let even = costs.even_rays().expect("the rays decide");
            // Four constants stand for five scenes; a factor of 1.3 is what they leave over at most.
            assert!((even / measured).ln().abs() < 1.3f64.ln(), "{name}: {even}");
            assert!(!costs.is_free(even * 0.99) && costs.is_free(even * 1.01), "{name}");
        }
    }

    #[test]
    fn the_choice_turns_at_most_once_and_agrees_with_the_numbers() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut free_at_last = [0; 2];
        for _ in 0..2_000 {
            let mut up_to = |most: f64| most.powf(random.f64());
            let (fuzzy, clusters, rebuilt, triangles) = (up_to(1e4), up_to(1e3), up_to(1e3), up_to(1e7));
            let costs = costs(fuzzy, clusters, rebuilt, triangles as usize);
            let rays = (-1_000..1_024).map(|power| 2f64.powi(power)).chain([f64::MAX]);
            let chosen: Vec<bool> = rays.clone().map(|rays| costs.is_free(rays)).collect();
            let turns = chosen.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(turns <= 1, "{costs:?}");
            assert_eq!(turns == 1, costs.even_rays().is_some(), "{costs:?}");
            assert!(!costs.is_free(0.0), "nothing pays for a hierarchy that no ray meets");
            // With hardly a ray only frames count: hierarchies cost by triangles, fuzzy trees by clusters.
            assert_eq!(chosen[0], costs.rebuilt.frame < costs.fuzzy.frame);
            // With rays without end only rays count.
            assert_eq!(chosen[chosen.len() - 1], costs.rebuilt.ray < costs.fuzzy.ray);
            free_at_last[usize::from(chosen[chosen.len() - 1])] += 1;
            for (rays, free) in rays.zip(&chosen) {
                let (fuzzy, rebuilt) = (costs.fuzzy_milliseconds(rays), costs.rebuilt_milliseconds(rays));
                assert!(fuzzy.is_finite() && rebuilt.is_finite());
                assert!(
                    if *free { rebuilt <= fuzzy } else { fuzzy <= rebuilt },
                    "{costs:?} at {rays}"
                );
            }
        }
        assert!(free_at_last.iter().all(|count| *count > 100), "{free_at_last:?}");
    }

    #[test]
    fn nothing_to_trace_costs_nothing() {
        let costs = StructureCost::default();
        assert_eq!(
            (costs.fuzzy_milliseconds(9.0), costs.rebuilt_milliseconds(9.0)),
            (0.0, 0.0)
        );
        assert!(costs.even_rays().is_none() && !costs.is_free(9.0));
    }

    #[test]
    fn clusters_that_turn_over_are_rebuilt_in_either_way() {
        let turning = FuzzyTrees {
            cost: 20.0,
            clusters: 1.0,
            rebuilt_triangles: 1_000.0,
        };
        let costs = StructureCost::new(&turning, 20.0, 1_000);
        assert_eq!(costs.fuzzy.frame - costs.rebuilt.frame, CLUSTER_NANOSECONDS);
        assert!(costs.is_free(1.0), "what is built anyway needs no clusters");
    }
}
