#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Ray,
    cluster_frame::WORLD_RAY_ERROR,
    simd::{Lanes, Portable, SimdLevel},
    wide::{WideNode, boxes::WideBoxes, ray::ORIGIN_SLACK},
};

/// 2³⁰: components of directions that are longer, or all shorter than its inverse, are left to single rays, which scale
/// them.
const DIRECTION_LIMIT: f32 = (1u32 << 30) as f32;

/// 2⁻⁵⁴: shorter components count as this long, forwards, so that they have an inverse. Some component is longer than the inverse
/// of [`DIRECTION_LIMIT`], and a ray inside boxes at a distance of at most D along each axis has `|t·d| ≤ D`; so that moves it by
/// at most 2·2⁻⁵⁴·2³⁰·D = 2u·D, where the margin of 16u·D has 6u·D to spare (`cluster_frame`).
const SHORTEST: f32 = 1.0 / (1u64 << 54) as f32;

/// A component of a direction as bundles take it.
#[inline(always)]
pub(super) fn lengthened(component: f32) -> f32 {
    if component.abs() < SHORTEST {
        SHORTEST
    } else {
        component
    }
}

/// 2⁻¹¹⁸: a `t` that underflows is off by at most 2⁻¹⁵⁰, which is a length of 2⁻¹²⁰ along such a direction.
const FLOOR: f32 = 1.0 / (1u128 << 118) as f32;

const CHAINS: usize = 4;

/// Coherent rays in world space: intervals of what they are made of. `t` is the rays' own, not scaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayBundle {
    /// Least and greatest origins.
    origin: [[f32; 3]; 2],
    /// Least and greatest inverses of directions: per axis of one sign, and finite.
    inverse_direction: [[f32; 3]; 2],
    /// What the longest component of each direction is at least, and not below the inverse of [`DIRECTION_LIMIT`].
    pub longest: f32,
    /// Before the least `t_min`.
    pub start: f32,
    /// Behind the greatest `t_max`.
    pub end: f32,
}

impl RayBundle {
    /// Of some rays, but for numbers among them that are none; `None` where they do not all run the same way along each
    /// axis, or their directions are too long or short. Rays that hardly move along an axis run forwards.
    pub(super) fn around(level: SimdLevel, rays: &[Ray]) -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, rays: &[Ray]) -> Option<RayBundle> {
                RayBundle::around_with(simd, rays)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, rays) };
        }
        Self::around_with(Portable, rays)
    }

    #[inline(always)]
    fn around_with<S: Lanes>(simd: S, rays: &[Ray]) -> Option<Self> {
        // A ray is a vector. Several chains, so that none waits for the one before it.
        let mut least = [simd.splat8(f32::INFINITY); CHAINS];
        let mut greatest = [simd.splat8(f32::NEG_INFINITY); CHAINS];
        for rays in rays.chunks(CHAINS) {
            for (chain, ray) in rays.iter().enumerate() {
                let ray = simd.load8(bytemuck::cast_ref(ray));
                least[chain] = simd.min8(ray, least[chain]);
                greatest[chain] = simd.max8(ray, greatest[chain]);
            }
        }
        let mut ends = [[0.0; 8]; 2];
        let [a, b, c, d] = least;
        simd.store8(simd.min8(simd.min8(a, b), simd.min8(c, d)), &mut ends[0]);
        let [a, b, c, d] = greatest;
        simd.store8(simd.max8(simd.max8(a, b), simd.max8(c, d)), &mut ends[1]);
        let three = |row: usize| ends.map(|end| std::array::from_fn(|k| end[row + k]));
        Self::new(three(0), three(3), [ends[0][6], ends[1][7]])
    }

    #[inline(always)]
    fn new(origin: [[f32; 3]; 2], [low, high]: [[f32; 3]; 2], [t_min, t_max]: [f32; 2]) -> Option<Self> {
        let lengthened = |d: [f32; 3]| [lengthened(d[0]), lengthened(d[1]), lengthened(d[2])];
        let (low, high) = (lengthened(low), lengthened(high));
        let mut longest = 0.0f32;
        for k in 0..3 {
            let (shortest, length) = if low[k] > 0.0 {
                (low[k], high[k])
            } else {
                (-high[k], -low[k])
            };
            if shortest < SHORTEST || length > DIRECTION_LIMIT {
                return None;
            }
            longest = longest.max(shortest);
        }
        let inverse = |direction: [f32; 3]| std::array::from_fn(|k| 1.0 / direction[k]);
        (longest >= 1.0 / DIRECTION_LIMIT).then(|| Self {
            origin,
            inverse_direction: [inverse(high), inverse(low)],
            longest,
            start: t_min.next_down(),
            end: t_max.next_up(),
        })
    }

    /// By how much the planes of boxes inside `bounds` move, per axis: the margin of the farthest of the rays, and what
    /// folding it into an origin needs (see [`WideRay`](crate::wide::WideRay)).
    #[inline]
    pub(super) fn outwards(&self, bounds: &Aabb) -> [f32; 3] {
        let margin = WORLD_RAY_ERROR * self.distance(bounds) + FLOOR;
        origin_slack(&self.origin).map(|slack| slack + margin)
    }

    /// The greatest distance per axis from where a ray begins to a point of `bounds`.
    #[inline]
    pub(super) fn distance(&self, bounds: &Aabb) -> f32 {
        let [low, high] = &self.origin;
        let far = |far: f32, k: usize| far.max(bounds.max[k] - low[k]).max(high[k] - bounds.min[k]);
        (0..3).fold(0.0, far)
    }

    /// Roughly which part of the cross-section of `bounds` the bundle covers, up to `limit`: what it may meet that each of
    /// its rays alone does not.
    ///
    /// As wide as interval arithmetic sees it: where directions differ in length, so do their slopes.
    pub(super) fn breadth(&self, bounds: &Aabb, limit: f32) -> f32 {
        let [inverse_high, inverse_low] = &self.inverse_direction;
        // Along each axis, by magnitude: the least and the greatest component.
        let components: [[f32; 2]; 3] = std::array::from_fn(|k| {
            let (a, b) = (1.0 / inverse_high[k].abs(), 1.0 / inverse_low[k].abs());
            [a.min(b), a.max(b)]
        });
        let longest = |best: usize, k: usize| {
            if components[k][0] > components[best][0] {
                k
            } else {
                best
            }
        };
        let along = (1..3).fold(0, longest);
        let [least, greatest] = components[along];
        let [low, high] = &self.origin;
        let behind = if inverse_low[along] > 0.0 {
            bounds.max[along] - low[along]
        } else {
            high[along] - bounds.min[along]
        };
        let depth = behind.min(limit * greatest);
        let across = [(along + 1) % 3, (along + 2) % 3];
        across.iter().fold(1.0, |part, k| {
            let slopes = [components[*k][0] / greatest, components[*k][1] / least];
            let apart = (high[*k] - low[*k]) + (high[along] - low[along]) * slopes[1];
            let width = apart + depth * (slopes[1] - slopes[0]);
            // A NaN covers all.
            part * (width / (bounds.max[*k] - bounds.min[*k])).min(1.0)
        })
    }
}

/// What folding a margin into origins needs, per axis (see [`WideRay`](crate::wide::WideRay)).
#[inline]
pub(super) fn origin_slack([low, high]: &[[f32; 3]; 2]) -> [f32; 3] {
    std::array::from_fn(|k| ORIGIN_SLACK * low[k].abs().max(high[k].abs()))
}

/// A bundle ready for nodes whose boxes are `f32`, with the margin that boxes inside of some bounds need.
///
/// # Why it misses nothing that one of its rays hits
///
/// Take each ray with its direction [`lengthened`], which the margin has room for. The bundle's margin is that of the ray with
/// the greatest distance, and its origins are the outermost of all. Rounding is monotone, so `a = fl(plane − near)` is not above what [`WideRay`](crate::wide::WideRay) computes for any of the rays; and a
/// product being monotone in either factor, the lesser of `fl(a·i)` over both ends i of the interval of inverses is not
/// above that ray's. Far planes go the other way. So where such a ray's own test passes, the bundle's does. That directions are
/// not scaled here changes only what underflows, which the floor of the margin covers, and by how much they are lengthened.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideBundle {
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    pub(super) inverse_direction: [[f32; 3]; 2],
    pub(super) near_row: [usize; 3],
    /// The least `t` that counts for any of the rays: where a traversal starts.
    pub start: f32,
}

impl WideBundle {
    /// In world space. `None` where distances overflow.
    #[inline]
    pub(super) fn new(bundle: &RayBundle, bounds: &Aabb) -> Option<Self> {
        let outwards = bundle.outwards(bounds);
        Self::from_extremes(&bundle.origin, bundle.inverse_direction, outwards, bundle.start)
    }

    /// Of least and greatest origins and inverses of directions, where planes move by `outwards`. `None` where distances overflow.
    #[inline]
    pub(super) fn from_extremes(
        [low, high]: &[[f32; 3]; 2],
        inverse_direction: [[f32; 3]; 2],
        outwards: [f32; 3],
        start: f32,
    ) -> Option<Self> {
        let mut out = Self {
            near: [0.0; 3],
            far: [0.0; 3],
            inverse_direction,
            near_row: [0; 3],
            start,
        };
        let mut reach = 0.0;
        for k in 0..3 {
            let (above, below) = (high[k] + outwards[k], low[k] - outwards[k]);
            let forward = inverse_direction[0][k] > 0.0;
            (out.near[k], out.far[k]) = if forward { (above, below) } else { (below, above) };
            out.near_row[k] = usize::from(!forward);
            reach += above.abs() + below.abs();
        }
        reach.is_finite().then_some(out)
    }

    /// Whether one of the rays may be inside one of a node's boxes.
    pub(super) fn meets_any(&self, level: SimdLevel, node: &WideNode, limit: f32) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, bundle: &WideBundle, node: &WideNode, limit: f32) -> bool {
                bundle.meets_any_with(simd, node, limit)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, node, limit) };
        }
        self.meets_any_with(Portable, node, limit)
    }

    #[inline(always)]
    fn meets_any_with<S: Lanes>(&self, simd: S, node: &WideNode, limit: f32) -> bool {
        let [enter, exit] = node.meet(simd, 0, self, self.start, limit);
        simd.le8(enter, exit) != 0
    }
}

impl WideBoxes<WideBundle> for WideNode {
    #[inline(always)]
    fn children(&self) -> &[u32; 8] {
        &self.children
    }

    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, _at: u32, bundle: &WideBundle, start: f32, limit: f32) -> [S::F8; 2] {
        let (mut enter, mut exit) = (simd.splat8(start), simd.splat8(limit));
        let [least, greatest] = &bundle.inverse_direction;
        for k in 0..3 {
            let near_row = bundle.near_row[k] & 1;
            let (near, far) = (&self.planes[near_row][k], &self.planes[1 - near_row][k]);
            let (least, greatest) = (simd.splat8(least[k]), simd.splat8(greatest[k]));
            let near = simd.sub8(simd.load8(near), simd.splat8(bundle.near[k]));
            let far = simd.sub8(simd.load8(far), simd.splat8(bundle.far[k]));
            let near = simd.min8(simd.mul8(near, least), simd.mul8(near, greatest));
            let far = simd.max8(simd.mul8(far, least), simd.mul8(far, greatest));
            enter = simd.max8(near, enter);
            exit = simd.min8(far, exit);
        }
        [enter, exit]
    }
}
