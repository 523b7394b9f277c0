use super::Oracle;
use restpose_runtime::{Aabb, Ray};

/// What a test ray is good at finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// Between two points of a box twice the model's size: the ordinary case.
    Random,
    /// Along a coordinate axis, through a vertex's coordinates or a random point: zero direction components.
    AxisParallel,
    /// At a vertex.
    Vertex,
    /// At a point of an edge.
    Edge,
    /// In the plane of a triangle, or tilted out of it by a hair.
    Grazing,
    /// From a point on a triangle, or close to one.
    FromSurface,
    /// From far away, at a random triangle.
    Distant,
}

impl RayKind {
    /// All kinds, in the order in which [`Rays`] takes turns.
    pub const ALL: [Self; 7] = [
        Self::Random,
        Self::AxisParallel,
        Self::Vertex,
        Self::Edge,
        Self::Grazing,
        Self::FromSurface,
        Self::Distant,
    ];
}

/// An endless, seeded supply of test rays around an oracle's triangles, kinds in turn. Directions have any length; one
/// ray in four has a bounded range.
pub struct Rays<'a> {
    oracle: &'a Oracle,
    bounds: Aabb,
    random: fastrand::Rng,
    next: usize,
}

impl<'a> Rays<'a> {
    /// Rays around `oracle`'s triangles, of which there is at least one.
    #[must_use]
    pub fn new(oracle: &'a Oracle, seed: u64) -> Self {
        let bounds = Aabb::around((0..oracle.triangle_count()).flat_map(|index| oracle.corners(index)));
        Self {
            oracle,
            bounds,
            random: fastrand::Rng::with_seed(seed),
            next: 0,
        }
    }

    fn signed(&mut self) -> f32 {
        self.random.f32() * 2.0 - 1.0
    }

    /// A point of the box around the model, grown by `factor`.
    fn point(&mut self, factor: f32) -> [f32; 3] {
        let center = self.bounds.center();
        let half: [f32; 3] = std::array::from_fn(|k| 0.5 * self.bounds.max[k] - 0.5 * self.bounds.min[k]);
        let largest = half[0].max(half[1]).max(half[2]);
        std::array::from_fn(|k| center[k] + self.signed() * factor * (half[k] + 0.1 * largest))
    }

    fn corners(&mut self) -> [[f32; 3]; 3] {
        let index = self.random.usize(..self.oracle.triangle_count());
        self.oracle.corners(index)
    }

    fn towards(from: [f32; 3], to: [f32; 3]) -> Ray {
        Ray::new(from, std::array::from_fn(|k| to[k] - from[k]))
    }

    /// The ray of `kind` that comes next.
    pub fn ray(&mut self, kind: RayKind) -> Ray {
        match kind {
            RayKind::Random => {
                let from = self.point(2.0);
                let to = self.point(2.0);
                Self::towards(from, to)
            }
            RayKind::AxisParallel => {
                let axis = self.random.usize(..3);
                let mut origin = if self.random.bool() {
                    self.corners()[0]
                } else {
                    self.point(1.0)
                };
                let sign = if self.random.bool() { 1.0 } else { -1.0 };
                let mut direction = [if self.random.bool() { 0.0 } else { -0.0 }; 3];
                direction[axis] = sign;
                let away = self.bounds.max[axis] - self.bounds.min[axis];
                origin[axis] -= sign * away * self.random.f32() * 2.0;
                Ray::new(origin, direction)
            }
            RayKind::Vertex => {
                let from = self.point(2.0);
                let to = self.corners()[self.random.usize(..3)];
                Self::towards(from, to)
            }
            RayKind::Edge => {
                let from = self.point(2.0);
                let [a, b, _] = self.corners();
                let s = self.random.f32();
                Self::towards(from, std::array::from_fn(|k| a[k] + s * (b[k] - a[k])))
            }
            RayKind::Grazing => {
                let [a, b, c] = self.corners();
                let (s, t) = (self.signed() * 3.0, self.signed() * 3.0);
                let hair = if self.random.bool() { 0.0 } else { 1e-4 };
                let from = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                let to = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0 + hair * self.signed() * (b[k] - a[k]));
                Self::towards(from, to)
            }
            RayKind::FromSurface => {
                let [a, b, c] = self.corners();
                let (s, t) = (self.random.f32() * 0.5, self.random.f32() * 0.5);
                let from = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                let to = self.point(1.0);
                Self::towards(from, to)
            }
            RayKind::Distant => {
                let to = self.corners()[0];
                let far = self.point(1.0);
                let center = self.bounds.center();
                Self::towards(std::array::from_fn(|k| center[k] + (far[k] - center[k]) * 1000.0), to)
            }
        }
    }
}

impl Iterator for Rays<'_> {
    type Item = Ray;

    fn next(&mut self) -> Option<Ray> {
        let kind = RayKind::ALL[self.next % RayKind::ALL.len()];
        self.next += 1;
        let mut ray = self.ray(kind);
        if self.next.is_multiple_of(4) {
            ray.t_min = self.random.f32() * 0.5;
            ray.t_max = ray.t_min + self.random.f32() * 2.0;
        }
        Some(ray)
    }
}
