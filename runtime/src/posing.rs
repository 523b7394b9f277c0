/// How the triangles of an instance are posed for rays. Hits do not depend on it, only time and memory do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Posing {
    /// As the rays come: at first a triangle is posed when a ray reaches it, from some number of rays on its vertices are
    /// remembered, and from some more the whole instance is posed and its tree refitted, once for its pose; at the first ray,
    /// where as many came in the last frame.
    #[default]
    Chosen,
    /// As [`Posing::Chosen`] would in the end, from the first of so many rays on.
    Expecting(u32),
    /// A triangle is posed whenever a ray reaches it. Keeps nothing.
    Recomputed,
    /// A vertex is posed when a ray first reaches a triangle of its. Keeps 16 bytes per vertex of an instance that rays
    /// reach.
    Remembered,
    /// All of it is posed and its tree refitted when the first ray enters its box. Keeps about 60 bytes per triangle.
    Whole,
}

/// Rays that enter an instance before more of it is posed than they reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosingLimits {
    /// Before its vertices are remembered.
    pub remembered: u32,
    /// Before the whole of it is posed.
    pub whole: u32,
    /// Rays beyond these are not counted.
    pub counted: u32,
}

/// What posing costs in nanoseconds, measured on one thread (`restpose measure frame`, cesium_man at 75k triangles): only
/// ratios matter.
struct Costs;

impl Costs {
    /// Posing a vertex with others.
    const VERTEX: f64 = 6.0;
    /// Refitting the tree over a triangle.
    const TRIANGLE: f64 = 12.0;
    /// A ray through the clusters.
    const RAY: f64 = 1000.0;
}

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
        let whole = (vertices as f64 * Costs::VERTEX + triangles as f64 * Costs::TRIANGLE) / Costs::RAY;
        let whole = whole as u32;
        Self {
            remembered: whole / 8,
            whole,
            counted: whole,
        }
    }

    /// The limits of a way of posing, of an instance that so many rays entered in the last frame.
    pub(crate) fn of(&self, posing: Posing, last_rays: u32) -> Self {
        let fixed = |remembered, whole| Self {
            remembered,
            whole,
            counted: 0,
        };
        match posing {
            // As many are expected again: then there is nothing to wait for.
            Posing::Chosen => Self {
                counted: self.counted,
                remembered: if last_rays >= self.remembered {
                    0
                } else {
                    self.remembered
                },
                whole: if last_rays >= self.whole { 0 } else { self.whole },
            },
            Posing::Expecting(rays) if rays >= self.whole => fixed(0, 0),
            Posing::Expecting(rays) if rays >= self.remembered => fixed(0, u32::MAX),
            Posing::Expecting(_) | Posing::Recomputed => Self::NONE,
            Posing::Remembered => fixed(0, u32::MAX),
            Posing::Whole => fixed(0, 0),
        }
    }
}
