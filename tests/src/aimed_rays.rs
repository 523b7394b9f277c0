use crate::Landmarks;
use restpose_runtime::{Aabb, Ray};

/// What a ray is aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// From a point of a split plane of a fuzzy tree.
    SplitPlane,
    /// From a point of a face of a cluster's world box.
    BoxFace,
    /// From a point of a side of a triangle's box in the fuzzy tree.
    LatticePlane,
    /// From a vertex.
    Vertex,
    /// From a point of a triangle's plane, along it.
    TrianglePlane,
    /// Along an edge.
    Edge,
    /// Along a coordinate axis through a vertex.
    Axis,
    /// With direction components at the ends of the range of `f32`.
    OddDirection,
    /// Between two points around the model.
    Anywhere,
}

impl Aim {
    /// All aims, in the order in which [`AimedRays`] takes turns.
    pub const ALL: [Self; 9] = [
        Self::SplitPlane,
        Self::BoxFace,
        Self::LatticePlane,
        Self::Vertex,
        Self::TrianglePlane,
        Self::Edge,
        Self::Axis,
        Self::OddDirection,
        Self::Anywhere,
    ];
}

/// Direction components at which arithmetic changes its ways: zeros of both signs, subnormal, smallest normal, with an
/// inverse that overflows, largest.
pub const ODD_COMPONENTS: [f32; 13] = [
    0.0,
    -0.0,
    f32::from_bits(1),
    -f32::from_bits(1),
    1e-40,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    2.9e-39,
    1e-20,
    1.0,
    -1.0,
    1e30,
    -f32::MAX,
];

/// An endless, seeded supply of rays from and along the places where traversal decides. One ray in three has a range of
/// its own: reaching backwards, bounded, or empty.
pub struct AimedRays<'a> {
    marks: &'a Landmarks,
    bounds: Aabb,
    random: fastrand::Rng,
    next: usize,
}

impl<'a> AimedRays<'a> {
    /// Rays for these landmarks, which have a triangle.
    #[must_use]
    pub fn new(marks: &'a Landmarks, seed: u64) -> Self {
        Self {
            marks,
            bounds: Aabb::around(marks.triangles.as_flattened().iter().copied()),
            random: fastrand::Rng::with_seed(seed),
            next: 0,
        }
    }

    fn signed(&mut self) -> f32 {
        self.random.f32() * 2.0 - 1.0
    }

    fn triangle(&mut self) -> [[f32; 3]; 3] {
        let index = self.random.usize(..self.marks.triangles.len());
        let [a, b, c] = self.marks.triangles[index];
        [[a, b, c], [b, c, a], [c, a, b]][self.random.usize(..3)]
    }

    /// A point of a box, grown about its middle.
    fn point(&mut self, bounds: &Aabb, factor: f32) -> [f32; 3] {
        let center = bounds.center();
        std::array::from_fn(|k| center[k] + self.signed() * factor * (0.5 * bounds.max[k] - 0.5 * bounds.min[k]))
    }

    /// At something, within a plane across `axis` every other time.
    fn direction(&mut self, from: [f32; 3], axis: usize) -> [f32; 3] {
        let bounds = self.bounds;
        let to = if self.random.bool() {
            self.triangle()[0]
        } else {
            self.point(&bounds, 1.0)
        };
        let mut direction: [f32; 3] = std::array::from_fn(|k| to[k] - from[k]);
        match self.random.u32(..4) {
            0 => direction[axis] = 0.0,
            1 => direction[axis] = -0.0,
            _ => {}
        }
        direction
    }

    fn axis_direction(&mut self) -> [f32; 3] {
        let mut direction = [if self.random.bool() { 0.0 } else { -0.0 }; 3];
        direction[self.random.usize(..3)] = if self.random.bool() { 1.0 } else { -1.0 };
        direction
    }

    /// A point whose local coordinate on one axis is that of a plane, and the axis.
    fn local_plane(&mut self, lattice: bool) -> ([f32; 3], usize) {
        let marks = self.marks;
        let of_cluster = |planes: &'a crate::LocalPlanes| if lattice { &planes.sides } else { &planes.splits };
        let clusters: Vec<_> = marks
            .local
            .iter()
            .filter(|planes| !of_cluster(planes).is_empty())
            .collect();
        if clusters.is_empty() {
            return self.box_face();
        }
        let planes = clusters[self.random.usize(..clusters.len())];
        let (axis, plane) = of_cluster(planes)[self.random.usize(..of_cluster(planes).len())];
        let mut local = self.point(&planes.bounds, 1.5);
        local[axis] = plane;
        (planes.world_from_local.transform_point(local), axis)
    }

    fn box_face(&mut self) -> ([f32; 3], usize) {
        let index = self.random.usize(..self.marks.world_boxes.len());
        let bounds = self.marks.world_boxes[index];
        let mut point = self.point(&bounds, 1.2);
        let axis = self.random.usize(..3);
        point[axis] = if self.random.bool() { bounds.min } else { bounds.max }[axis];
        (point, axis)
    }

    /// The ray for `aim` that comes next.
    pub fn ray(&mut self, aim: Aim) -> Ray {
        let bounds = self.bounds;
        match aim {
            Aim::SplitPlane | Aim::LatticePlane | Aim::BoxFace => {
                let (origin, axis) = match aim {
                    Aim::SplitPlane => self.local_plane(false),
                    Aim::LatticePlane => self.local_plane(true),
                    _ => self.box_face(),
                };
                Ray::new(origin, self.direction(origin, axis))
            }
            Aim::Vertex => {
                let origin = self.triangle()[0];
                let axis = self.random.usize(..3);
                Ray::new(origin, self.direction(origin, axis))
            }
            Aim::TrianglePlane => {
                let [a, b, c] = self.triangle();
                let mut inside = |spread: f32| -> [f32; 3] {
                    let (s, t) = (self.signed() * spread, self.signed() * spread);
                    std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]))
                };
                let (from, to) = (inside(2.0), inside(1.0));
                Ray::new(from, std::array::from_fn(|k| to[k] - from[k]))
            }
            Aim::Edge => {
                let [a, b, _] = self.triangle();
                let direction: [f32; 3] = std::array::from_fn(|k| b[k] - a[k]);
                let back = [0.0, 0.5, 1.0, 16.0][self.random.usize(..4)];
                Ray::new(std::array::from_fn(|k| a[k] - back * direction[k]), direction)
            }
            Aim::Axis => {
                let (mut origin, direction) = (self.triangle()[0], self.axis_direction());
                let back = self.random.f32() * 2.0;
                for k in 0..3 {
                    origin[k] -= back * direction[k] * (bounds.max[k] - bounds.min[k]);
                }
                Ray::new(origin, direction)
            }
            Aim::OddDirection => {
                let origin = if self.random.bool() {
                    self.triangle()[0]
                } else {
                    self.point(&bounds, 2.0)
                };
                let direction = std::array::from_fn(|_| ODD_COMPONENTS[self.random.usize(..ODD_COMPONENTS.len())]);
                Ray::new(origin, direction)
            }
            Aim::Anywhere => {
                let (from, to) = (self.point(&bounds, 2.0), self.point(&bounds, 1.0));
                Ray::new(from, std::array::from_fn(|k| to[k] - from[k]))
            }
        }
    }
}

impl Iterator for AimedRays<'_> {
    type Item = Ray;

    fn next(&mut self) -> Option<Ray> {
        let aim = Aim::ALL[self.next % Aim::ALL.len()];
        self.next += 1;
        let mut ray = self.ray(aim);
        if self.next.is_multiple_of(3) {
            let start = self.signed();
            let ranges = [
                (f32::NEG_INFINITY, f32::INFINITY),
                (f32::NEG_INFINITY, 0.0),
                (start, start + self.random.f32()),
                (start, start),
                (0.0, -0.0),
                (1.0, start),
            ];
            (ray.t_min, ray.t_max) = ranges[self.random.usize(..ranges.len())];
        }
        Some(ray)
    }
}
