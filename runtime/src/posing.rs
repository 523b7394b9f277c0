use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// How the triangles of an instance are posed for rays. Hits do not depend on it, only time and memory do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Posing {
    /// As the rays come: at first a triangle is posed when a ray reaches it, from some number of rays on its vertices are
    /// remembered, and from some more the whole instance is posed and its tree refitted, once for its pose; at the first ray,
    /// where as many came in the last frame.
    #[default]
    Chosen,
    /// As [`Posing::Chosen`], where so many rays are expected in place of those of the last frame.
    Expecting(u32),
    /// A triangle is posed whenever a ray reaches it. Keeps nothing.
    Recomputed,
    /// A vertex is posed when a ray first reaches a triangle of its. Keeps 16 bytes per vertex of an instance that rays
    /// reach.
    Remembered,
    /// All of it is posed and its tree refitted when the first ray enters its box. Keeps about 60 bytes per triangle.
    Whole,
}

/// What rays cost an instance before more of it is posed than they reach. The unit is a triangle, posed and tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosingLimits {
    /// Before its vertices are remembered.
    pub remembered: u32,
    /// Before the whole of it is posed.
    pub whole: u32,
    /// What is beyond this is not counted.
    pub counted: u32,
}

/// What posing costs in nanoseconds, measured on one thread (`restpose measure frame`, skins of 75k and 147k triangles):
/// only ratios matter.
struct Costs;

impl Costs {
    /// Posing a vertex with others.
    const VERTEX: f64 = 6.0;
    /// Refitting the tree over a triangle.
    const TRIANGLE: f64 = 12.0;
    /// Posing and testing a triangle that a ray reaches.
    const TEST: f64 = 80.0;
}

/// What it costs a ray to enter an instance and its clusters.
const ENTRY: u32 = 4;

/// What a ray costs where nothing is known of the instance: of skins of 5k to 300k triangles, 6 to 80.
const UNKNOWN_RAY: f64 = 12.0;

impl Default for PosingLimits {
    fn default() -> Self {
        Self::NONE
    }
}

impl PosingLimits {
    /// Nothing is posed beforehand.
    pub(crate) const NONE: Self = Self {
        remembered: u32::MAX,
        whole: u32::MAX,
        counted: 0,
    };

    /// The limits of an asset with so many vertices and triangles where nothing is known of the rays to come: when they
    /// have taken as long as posing the whole, so that the total is at most twice that of the better way.
    pub(crate) fn new(vertices: usize, triangles: usize) -> Self {
        let whole = (vertices as f64 * Costs::VERTEX + triangles as f64 * Costs::TRIANGLE) / Costs::TEST;
        let whole = whole as u32;
        Self {
            remembered: whole / 8,
            whole,
            counted: whole,
        }
    }

    /// The limits of a way of posing, of an instance of which so much is expected.
    pub(crate) fn of(&self, posing: Posing, expected: &Expected) -> Self {
        let work = match posing {
            Posing::Chosen => expected.work,
            Posing::Expecting(rays) => f64::from(rays) * expected.per_ray,
            Posing::Recomputed => return Self::NONE,
            Posing::Remembered => {
                return Self {
                    remembered: 0,
                    ..Self::NONE
                };
            }
            Posing::Whole => {
                return Self {
                    remembered: 0,
                    whole: 0,
                    counted: 0,
                };
            }
        };
        // What is expected need not be waited for.
        let at_once = |limit: u32| if work >= f64::from(limit) { 0 } else { limit };
        Self {
            remembered: at_once(self.remembered),
            whole: at_once(self.whole),
            counted: self.counted,
        }
    }
}

/// What rays cost an instance in its pose, as far as it is counted.
#[derive(Debug, Default)]
pub(crate) struct Demand {
    /// Rays that met it before it was posed whole, and what they cost.
    rays: AtomicU32,
    work: AtomicU32,
    /// Rays that met it after.
    later_rays: AtomicU32,
}

impl Demand {
    pub(crate) fn begin(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn work(&self) -> u32 {
        self.work.load(Relaxed)
    }

    /// Counts a ray for which so many triangles were tested, where the whole was not posed.
    pub(crate) fn count(&self, tests: u32, limits: &PosingLimits) {
        // Beyond what matters nothing is counted, and threads do not meet here.
        if self.work() < limits.counted {
            self.rays.fetch_add(1, Relaxed);
            self.work.fetch_add(tests.saturating_add(ENTRY), Relaxed);
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
    work: f64,
    /// Where the whole was posed from the beginning, as in the last frame in which it was not.
    per_ray: f64,
}

impl Expected {
    pub(crate) const NOTHING: Self = Self {
        work: 0.0,
        per_ray: UNKNOWN_RAY,
    };

    /// After a frame; `None` for one in which no ray met the instance.
    pub(crate) fn after(&mut self, demand: Option<&Demand>) {
        let count = |of: fn(&Demand) -> &AtomicU32| demand.map_or(0.0, |demand| f64::from(of(demand).load(Relaxed)));
        let (rays, later) = (count(|demand| &demand.rays), count(|demand| &demand.later_rays));
        if rays > 0.0 {
            self.per_ray = count(|demand| &demand.work) / rays;
        }
        self.work = (rays + later) * self.per_ray;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of so many rays, each of which tests so many triangles: in which of them the whole was posed, and after how
    /// many rays.
    fn frames(rays: &[u32], tests: u32) -> Vec<Option<u32>> {
        let own = PosingLimits::new(10_000, 20_000);
        let mut expected = Expected::NOTHING;
        let frame = |rays: &u32| {
            let limits = own.of(Posing::Chosen, &expected);
            let demand = Demand::default();
            let mut whole = None;
            for ray in 0..*rays {
                if whole.is_some() {
                    demand.count_later(1, &limits);
                } else if demand.work() >= limits.whole {
                    whole = Some(ray);
                    demand.count_later(1, &limits);
                } else {
                    demand.count(tests, &limits);
                }
            }
            expected.after(Some(&demand));
            whole
        };
        rays.iter().map(frame).collect()
    }

    #[test]
    fn the_whole_is_posed_at_once_where_as_many_rays_came_before() {
        // 3,750 units: rays of 20 are worth it after 188, of 80 after 47.
        assert_eq!(
            frames(&[1000, 1000, 1000, 100, 100, 1000], 16),
            [Some(188), Some(0), Some(0), Some(0), None, Some(188)]
        );
        assert_eq!(frames(&[100, 100, 100], 76), [Some(47), Some(0), Some(0)]);
        assert_eq!(frames(&[100, 100], 16), [None, None]);
    }

    #[test]
    fn ways_that_are_asked_for_are_taken() {
        let own = PosingLimits::new(10_000, 20_000);
        let limits = |posing| {
            let limits = own.of(posing, &Expected::NOTHING);
            (limits.remembered, limits.whole)
        };
        assert_eq!(limits(Posing::Recomputed), (u32::MAX, u32::MAX));
        assert_eq!(limits(Posing::Remembered), (0, u32::MAX));
        assert_eq!(limits(Posing::Whole), (0, 0));
        assert_eq!(limits(Posing::Expecting(1_000_000)), (0, 0));
        assert_eq!(limits(Posing::Expecting(1)), limits(Posing::Chosen));
    }
}
