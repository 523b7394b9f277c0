use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// How the triangles of an instance are posed for rays. Hits do not depend on it, only time and memory do.
///
/// Rays at a time after the begin of an interval in which the instance [moves](crate::Scene::set_motion) always recompute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Posing {
    /// As the rays come: at first a triangle is posed when a ray reaches it, and from some number of rays on the whole
    /// instance is posed and its tree refitted, once for its pose; at the first ray, where as many came in the last frame.
    /// Where so many instances are whole that their trees do not stay in caches, only what saves more than that costs.
    #[default]
    Chosen,
    /// As [`Posing::Chosen`], where so many rays are expected in place of those of the last frame.
    Expecting(u32),
    /// A triangle is posed whenever a ray reaches it. Keeps nothing.
    Recomputed,
    /// A vertex is posed when a ray first reaches a triangle of its. Keeps 16 bytes per vertex of an instance that rays
    /// reach.
    Remembered,
    /// All of it is posed and its tree refitted when the first ray enters its box. Keeps about 50 bytes per triangle.
    Whole,
}

/// What rays cost an instance before more of it is posed than they reach. The unit is a triangle, posed and tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosingLimits {
    /// Whether its vertices are remembered.
    pub is_remembered: bool,
    /// What posing the whole of it takes; 0 to do so at the first ray, `u32::MAX` for never.
    whole: u32,
    /// What is beyond this is not counted.
    counted: u32,
    /// Of its whole, what rays come by again and again.
    kept_bytes: u32,
}

/// What posing costs in nanoseconds, measured on one thread with foxes of 576 to 147k triangles, alone and among others:
/// only ratios matter.
struct Costs;

impl Costs {
    /// Posing a vertex with others; 6 where the memory is in caches, 11 where it is not.
    const VERTEX: f64 = 8.0;
    /// Refitting the tree over a triangle; 10 and 22.
    const TRIANGLE: f64 = 16.0;
    /// Posing and testing a triangle that a ray reaches.
    const TEST: f64 = 80.0;
}

/// What a ray's way through clusters, and boxes that follow the pose, takes beyond one through the whole, its tests apart.
/// Both together were 290 to 750 ns, 1,100 where the file leaves the caches (fox of 576, 9.2k and 147k triangles, cesium_man of
/// 4.7k and 75k; 3 to 4 tests each).
const ENTRY: u32 = 4;

/// What rays of a bundle had to do on their way through the clusters of an instance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BundleWork {
    /// Clusters that they entered together, once each time.
    pub clusters: u32,
    /// Triangles that were posed for all of them.
    pub triangles: u32,
    /// Rays that left the bundle, once each time.
    pub lone: u32,
}

impl BundleWork {
    /// What the whole would have saved. Fitted to pictures of 4,000 to a million rays of foxes of 576 to 147k triangles and of
    /// ELEPHANT's 1.35 million; it is off by up to a third.
    fn saved(&self) -> u32 {
        5 * self.clusters + self.triangles + 2 * self.lone
    }
}

/// What a ray's way through a posed tree that is in no cache takes beyond one through a posed tree that is, while the file's,
/// which all instances share, stays there: of 16 foxes 390 ns, of 64 700, of 250 and more 1,000 to 1,400; less what it saves.
const COLD_RAY: u32 = ENTRY + 5;

/// Of posed trees, what rays come by again and again: 8 MiB are four times a second-level cache of today, and what its table
/// of pages covers.
const CACHED_BYTES: u64 = 8 << 20;

/// The upper levels of one tree and the vertices that its rays meet most: ten instances of 7 MB were as fast as one.
const KEPT_BYTES: f64 = (128 << 10) as f64;

/// Bytes of a whole per vertex and per triangle.
const WHOLE_BYTES: [f64; 2] = [12.0, 41.0];

/// What the whole saves a ray where nothing is known of the instance.
const UNKNOWN_RAY: f64 = 8.0;

impl Default for PosingLimits {
    fn default() -> Self {
        Self::NONE
    }
}

impl PosingLimits {
    /// Nothing is posed beforehand.
    pub(crate) const NONE: Self = Self {
        is_remembered: false,
        whole: u32::MAX,
        counted: 0,
        kept_bytes: 0,
    };

    /// The limits of an asset with so many vertices and triangles where nothing is known of the rays to come: when the whole
    /// would have saved as much as posing it takes, so that the total is at most twice that of the better way.
    pub(crate) fn new(vertices: usize, triangles: usize) -> Self {
        let sum = |[vertex, triangle]: [f64; 2]| vertices as f64 * vertex + triangles as f64 * triangle;
        let whole = (sum([Costs::VERTEX, Costs::TRIANGLE]) / Costs::TEST) as u32;
        Self {
            is_remembered: false,
            whole,
            // Enough to know whether rays save more than what they cost in a crowd.
            counted: whole.saturating_mul(16),
            kept_bytes: sum(WHOLE_BYTES).min(KEPT_BYTES) as u32,
        }
    }

    /// The limits of a way of posing, of an instance of which so much is expected, among so many that are whole.
    pub(crate) fn of(&self, posing: Posing, expected: &Expected, wholes: u32) -> Self {
        let rays = match posing {
            Posing::Chosen => expected.rays,
            Posing::Expecting(rays) => f64::from(rays),
            Posing::Recomputed => return Self::NONE,
            Posing::Remembered => {
                return Self {
                    is_remembered: true,
                    ..Self::NONE
                };
            }
            Posing::Whole => return Self { whole: 0, ..Self::NONE },
        };
        // What is expected need not be waited for.
        let saved = rays * (expected.per_ray - f64::from(self.cold_ray(wholes)));
        Self {
            whole: if saved >= f64::from(self.whole) { 0 } else { self.whole },
            ..*self
        }
    }

    /// Whether it is time to pose the whole; `wholes` tells how many are.
    #[inline]
    pub(crate) fn is_whole_due(&self, demand: &Demand, wholes: impl FnOnce() -> u32) -> bool {
        // A little more or less changes no hit.
        let work = demand.work.load(Relaxed);
        if work < self.whole || self.whole == u32::MAX {
            return false;
        }
        self.whole == 0 || {
            let cold = u64::from(demand.rays.load(Relaxed)) * u64::from(self.cold_ray(wholes()));
            u64::from(work) >= u64::from(self.whole) + cold
        }
    }

    /// What each ray would cost in one more whole beside so many.
    fn cold_ray(&self, wholes: u32) -> u32 {
        let kept = u64::from(wholes) * u64::from(self.kept_bytes);
        if kept > CACHED_BYTES { COLD_RAY } else { 0 }
    }
}

/// What rays cost an instance in its pose, as far as it is counted.
#[derive(Debug, Default)]
pub(crate) struct Demand {
    /// Rays that met it before it was posed whole, and what that would have saved them.
    rays: AtomicU32,
    work: AtomicU32,
    /// Rays that met it after.
    later_rays: AtomicU32,
}

impl Demand {
    pub(crate) fn begin(&mut self) {
        *self = Self::default();
    }

    /// Counts a ray for which so many triangles were tested, where the whole was not posed.
    pub(crate) fn count(&self, tests: u32, limits: &PosingLimits) {
        self.add(1, tests.saturating_add(ENTRY), limits);
    }

    /// Counts rays that went together, where the whole was not posed.
    pub(crate) fn count_bundle(&self, rays: u32, work: &BundleWork, limits: &PosingLimits) {
        self.add(rays, work.saved(), limits);
    }

    fn add(&self, rays: u32, work: u32, limits: &PosingLimits) {
        // Beyond what matters nothing is counted, and threads do not meet here.
        if self.work.load(Relaxed) < limits.counted && self.rays.load(Relaxed) < limits.counted {
            self.rays.fetch_add(rays, Relaxed);
            self.work.fetch_add(work, Relaxed);
        }
    }

    /// Counts rays that met the whole.
    pub(crate) fn count_later(&self, rays: u32, limits: &PosingLimits) {
        if self.later_rays.load(Relaxed) < limits.counted {
            self.later_rays.fetch_add(rays, Relaxed);
        }
    }
}

/// What an instance's rays are expected to cost: what those of the last frame did.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    rays: f64,
    /// Where the whole was posed from the beginning, as in the last frame in which it was not.
    per_ray: f64,
}

impl Expected {
    pub(crate) const NOTHING: Self = Self {
        rays: 0.0,
        per_ray: UNKNOWN_RAY,
    };

    /// After a frame; `None` for one in which no ray met the instance.
    pub(crate) fn after(&mut self, demand: Option<&Demand>) {
        let count = |of: fn(&Demand) -> &AtomicU32| demand.map_or(0.0, |demand| f64::from(of(demand).load(Relaxed)));
        let (rays, later) = (count(|demand| &demand.rays), count(|demand| &demand.later_rays));
        if rays > 0.0 {
            self.per_ray = count(|demand| &demand.work) / rays;
        }
        self.rays = rays + later;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of so many rays, each of which tests so many triangles, beside so many wholes: in which of them the whole was
    /// posed, and after how many rays.
    fn frames(rays: &[u32], tests: u32, wholes: u32) -> Vec<Option<u32>> {
        let own = PosingLimits::new(10_000, 20_000);
        let mut expected = Expected::NOTHING;
        let frame = |rays: &u32| {
            let limits = own.of(Posing::Chosen, &expected, wholes);
            let demand = Demand::default();
            let mut whole = None;
            for ray in 0..*rays {
                if whole.is_none() && limits.is_whole_due(&demand, || wholes) {
                    whole = Some(ray);
                }
                match whole {
                    Some(_) => demand.count_later(1, &limits),
                    None => demand.count(tests, &limits),
                }
            }
            expected.after(Some(&demand));
            whole
        };
        rays.iter().map(frame).collect()
    }

    #[test]
    fn the_whole_is_posed_at_once_where_as_many_rays_came_before() {
        // 5,000 tests: rays of 20 are worth it after 209, of 80 after 60, with what entering takes them.
        assert_eq!(
            frames(&[1000, 1000, 1000, 100, 100, 1000], 20, 0),
            [Some(209), Some(0), Some(0), Some(0), None, Some(209)]
        );
        assert_eq!(frames(&[100, 100, 100], 80, 0), [Some(60), Some(0), Some(0)]);
        assert_eq!(frames(&[100, 100], 20, 0), [None, None]);
        assert_eq!(frames(&[100_000; 2], 0, 0), [Some(1250), Some(0)]);
    }

    #[test]
    fn bundles_count_what_they_cost() {
        let own = PosingLimits::new(10_000, 20_000);
        let demand = Demand::default();
        let work = BundleWork {
            clusters: 100,
            triangles: 2_000,
            lone: 1_249,
        };
        demand.count_bundle(64, &work, &own);
        assert!(!own.is_whole_due(&demand, || 0));
        demand.count_bundle(
            64,
            &BundleWork {
                lone: 1,
                ..BundleWork::default()
            },
            &own,
        );
        assert!(own.is_whole_due(&demand, || 0), "5,000 tests");
    }

    /// 64 of these are what caches hold.
    #[test]
    fn in_a_crowd_the_whole_is_posed_where_it_saves_more_than_cold_memory_costs() {
        assert_eq!(frames(&[1000, 1000], 20, 64), [Some(209), Some(0)]);
        // A third of a ray's tests is not saved.
        assert_eq!(
            frames(&[1000, 1000, 300, 300], 15, 65),
            [Some(500), Some(0), Some(0), None]
        );
        assert_eq!(frames(&[100_000, 100_000], 5, 65), [None, None]);
        assert_eq!(frames(&[100_000, 100_000], 5, 64), [Some(556), Some(0)]);
    }

    /// More small instances are held than large ones, and no less of large ones the larger they are.
    #[test]
    fn what_is_kept_is_bounded() {
        let kept = |triangles: usize| PosingLimits::new(triangles / 2, triangles).kept_bytes;
        assert_eq!(
            (kept(100), kept(10_000), kept(1_000_000)),
            (4_700, 128 << 10, 128 << 10)
        );
    }

    #[test]
    fn ways_that_are_asked_for_are_taken() {
        let own = PosingLimits::new(10_000, 20_000);
        let limits = |posing| {
            let limits = own.of(posing, &Expected::NOTHING, 0);
            let demand = Demand::default();
            let is_due = |work: u32| {
                demand.work.store(work, Relaxed);
                limits.is_whole_due(&demand, || 0)
            };
            (limits.is_remembered, is_due(0), is_due(u32::MAX))
        };
        assert_eq!(limits(Posing::Recomputed), (false, false, false));
        assert_eq!(limits(Posing::Remembered), (true, false, false));
        assert_eq!(limits(Posing::Whole), (false, true, true));
        assert_eq!(limits(Posing::Expecting(1_000_000)), (false, true, true));
        assert_eq!(limits(Posing::Expecting(1)), (false, false, true));
        assert_eq!(limits(Posing::Chosen), (false, false, true));
    }
}
