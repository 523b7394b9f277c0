//! What the traversals of both kinds of tree have in common.
//!
//! Every builder's tree is traced by the same code, so that times compare trees. No hit is missed: the triangle test's
//! hit is an exact hit of a triangle whose corners are moved by at most [`VERTEX_ERROR`]`·D`, D the greatest distance per
//! axis from the ray's origin to the scene's box, and a slab's four roundings are 4u relative to the distance of its
//! plane, which is at most D. So planes count from [`MARGIN`]`·D` before them to as much behind.
//!
//! Based on: Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013. Differs: he widens `t` of the far planes; here the planes
//! move, because triangles do.

use super::scenes::Triangle;
use restpose_formats::geom::round::UNIT_ROUNDOFF;
use restpose_runtime::{
    Aabb, Ray,
    triangle::{PreparedRay, VERTEX_ERROR},
};

/// 6u of the triangle test, 4u of slabs, and as much again for the rounding of the margin and of D.
const MARGIN: f32 = (VERTEX_ERROR + 10.0 * UNIT_ROUNDOFF) as f32;

/// A hit, as every builder's tree must find it bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeHit {
    /// Ray parameter.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// The lowest of those hit at `t`.
    pub triangle: u32,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Inner nodes visited.
    pub steps: u64,
    /// Triangles tested.
    pub tests: u64,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.steps += other.steps;
        self.tests += other.tests;
    }
}

/// A ray on its way through a tree.
pub(super) struct Traveller<'a> {
    triangles: &'a [Triangle],
    prepared: PreparedRay,
    pub origin: [f32; 3],
    pub inverse_direction: [f32; 3],
    /// Planes count from this much before them to this much behind.
    pub margin: f32,
    /// `t` beyond which no box matters: one number behind the best hit.
    pub limit: f32,
    pub best: Option<TreeHit>,
    pub counts: Counts,
}

impl<'a> Traveller<'a> {
    /// `None` when the ray can hit nothing. The ray's direction must be about as long as the scene, or of length one: its
    /// components must not be subnormal.
    pub fn new(ray: &Ray, triangles: &'a [Triangle], bounds: &Aabb) -> Option<Self> {
        let far = (0..3).fold(0.0, |far: f32, k| {
            far.max(bounds.max[k] - ray.origin[k])
                .max(ray.origin[k] - bounds.min[k])
        });
        Some(Self {
            triangles,
            prepared: PreparedRay::new(ray)?,
            origin: ray.origin,
            inverse_direction: ray.direction.map(|d| 1.0 / d),
            margin: MARGIN * far + f32::MIN_POSITIVE,
            limit: ray.t_max.next_up(),
            best: None,
            counts: Counts::default(),
        })
    }

    /// Tests a triangle.
    #[inline]
    pub fn test(&mut self, triangle: u32) {
        self.counts.tests += 1;
        let Some(found) = self.prepared.intersect(&self.triangles[triangle as usize]) else {
            return;
        };
        let is_first = self
            .best
            .is_none_or(|best| found.t < best.t || (found.t == best.t && triangle < best.triangle));
        if is_first {
            self.limit = found.t.next_up();
            self.best = Some(TreeHit {
                t: found.t,
                u: found.u,
                v: found.v,
                triangle,
            });
        }
    }

    /// Where the ray may be inside `bounds`, from `t = start` to the limit; `None` when it is nowhere.
    ///
    /// Comparisons are written so that a NaN (a ray in the plane of a face) restricts nothing.
    #[inline]
    pub fn clip(&self, bounds: &Aabb, start: f32) -> Option<(f32, f32)> {
        let (mut enter, mut exit) = (start, self.limit);
        for k in 0..3 {
            let low = ((bounds.min[k] - self.origin[k]) - self.margin) * self.inverse_direction[k];
            let high = ((bounds.max[k] - self.origin[k]) + self.margin) * self.inverse_direction[k];
            let (near, far) = if self.inverse_direction[k].is_sign_positive() {
                (low, high)
            } else {
                (high, low)
            };
            enter = if near > enter { near } else { enter };
            exit = if far < exit { far } else { exit };
        }
        (enter <= exit).then_some((enter, exit))
    }
}

/// The hit with the least `t`, of equals the lowest triangle, by testing all.
pub(super) fn brute_force(ray: &Ray, triangles: &[Triangle]) -> Option<TreeHit> {
    let prepared = PreparedRay::new(ray)?;
    let mut best: Option<TreeHit> = None;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(found) = prepared.intersect(corners)
            && best.is_none_or(|best| found.t < best.t)
        {
            best = Some(TreeHit {
                t: found.t,
                u: found.u,
                v: found.v,
                triangle: triangle as u32,
            });
        }
    }
    best
}
