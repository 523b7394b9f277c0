/// How the triangles of an instance are posed for rays. Hits do not depend on it, only time and memory do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Posing {
    /// As the rays come: at first a triangle is posed when a ray reaches it, from some number of rays on its vertices are
    /// remembered, and from some more the whole instance is posed and its tree refitted, once for its pose.
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
}

/// What posing costs in nanoseconds, measured on one thread (`restpose measure frame`): only ratios matter.
struct Costs;

impl Costs {
    /// Posing a vertex with others.
    const VERTEX: f64 = 8.0;
    /// Refitting the tree over a triangle.
    const TRIANGLE: f64 = 14.0;
    /// What a ray saves that enters a whole instance instead of its clusters.
    const RAY: f64 = 600.0;
}

impl PosingLimits {
    /// The limits of an asset with so many vertices and triangles where [`Posing::Chosen`]: when rays have lost as much as
    /// posing the whole takes, so that the total is at most twice that of the better way.
    pub(crate) fn new(vertices: usize, triangles: usize) -> Self {
        let whole = (vertices as f64 * Costs::VERTEX + triangles as f64 * Costs::TRIANGLE) / Costs::RAY;
        Self {
            remembered: (whole / 8.0) as u32,
            whole: whole as u32,
        }
    }

    /// The limits of another way.
    pub(crate) fn of(&self, posing: Posing) -> Self {
        let (remembered, whole) = match posing {
            Posing::Chosen => return *self,
            Posing::Expecting(rays) if rays >= self.whole => (0, 0),
            Posing::Expecting(rays) if rays >= self.remembered => (0, u32::MAX),
            Posing::Expecting(_) | Posing::Recomputed => (u32::MAX, u32::MAX),
            Posing::Remembered => (0, u32::MAX),
            Posing::Whole => (0, 0),
        };
        Self { remembered, whole }
    }
}
