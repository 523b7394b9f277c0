use super::{EXTENT_LIMIT, F64_SLACK, FrameInputs, SlabLanes, SlabRay, UNDERFLOW_FLOOR, slab_ray::distance};
use crate::{
    affine64::wide,
    simd::{Doubles, Lanes, weighted_sum},
    triangle::VERTEX_ERROR,
};
use restpose_formats::geom::{
    Aabb,
    round::{UNIT_ROUNDOFF, f32_above},
};

/// Ray-dependent part of the margin, per unit of `Σ|L|·D`: triangle test 6u, ray transform γ₅ + γ₃ ≤ 8.1u, slabs 4u,
/// directions that are lengthened ([`SHORTEST`]) 1u, and the rounding of the margin itself; 24u covers them.
pub(super) const RAY_ERROR: f32 = (VERTEX_ERROR + 18.0 * UNIT_ROUNDOFF) as f32;

/// Components of directions in local space are at least this long, per unit of what stands for `Σ|L|` in the margin: u·`Σ|L|`.
/// Along shorter ones a ray moves by less than u·`Σ|L|`·D before it has passed the cluster, and by as much with this one, which
/// has an inverse: planes of a lattice could not restrict a ray that is parallel to them.
const SHORTEST: f32 = UNIT_ROUNDOFF as f32 / RAY_ERROR;

/// 2⁻⁶⁰: clusters of which the margin per unit of distance, about 24u·`Σ|L|`, is less than this or more than its inverse are left to
/// single rays.
const LEAST_SCALE: f32 = 1.0 / (1u64 << 60) as f32;

/// 2⁻⁹⁶: what bundles add to distances, for what underflows because their directions are not scaled. An operation underflows by at
/// most 2⁻¹⁵⁰. Of a `t` that is a length of 2⁻¹²⁰·`Σ|L|` along a direction of up to 2³⁰, where this adds 2⁻¹¹⁶·`Σ|L|` to the margin.
/// In a direction's component it is a length of 2⁻¹¹⁸·D where the direction is as short as 2⁻³⁰, far below the u·`Σ|L|`·D that the
/// margin has to spare, with such scales.
const BUNDLE_FLOOR: f32 = 1.0 / (1u128 << 96) as f32;

/// `x ↦ linear·(x − center_world) + center_local`, and the margins that go with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    /// Rows.
    linear: [[f32; 3]; 3],
    center_world: [f32; 3],
    center_local: [f32; 3],
    /// Points 1 to 4, and the terms of 6 and 7 in the size of the local box.
    margin_local: [f32; 3],
    /// The same for boxes that follow the pose, and so need no excess.
    margin_posed: [f32; 3],
    /// [`RAY_ERROR`]`·Σ|L|` per local axis.
    margin_per_distance: [f32; 3],
}

/// What a bundle needs of a cluster's local space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BundleFrame {
    /// The greatest of its rays' margins, and those for boxes that follow the pose.
    pub margin: [f32; 3],
    pub margin_posed: [f32; 3],
    /// Components of directions are at least this long.
    shortest: [f32; 3],
}

impl LocalFrame {
    /// `None` where numbers overflow. The inverse has rows; `extent` bounds the magnitudes in the local box, with the excess;
    /// `vertex_error` is what points 1 and 2 add to in world space, where `bounds_world` holds the cluster.
    #[inline(always)]
    pub(super) fn new<S: Lanes>(
        simd: S,
        inputs: &FrameInputs<S>,
        [u, v, w]: &[[f64; 3]; 3],
        extent: [f64; 3],
        vertex_error: Doubles<S>,
        bounds_world: &Aabb,
    ) -> Option<Self> {
        let x = &inputs.frame.map.columns;
        let center = bounds_world.center();
        let mut center_world = [0.0; 3];
        for k in 0..3 {
            // Halving a subnormal can leave the box.
            center_world[k] = center[k].max(bounds_world.min[k]).min(bounds_world.max[k]);
            if !center_world[k].is_finite() {
                return None;
            }
        }
        // Columns of the inverse, and of L.
        let exact = [
            [u[0], v[0], w[0], 0.0],
            [u[1], v[1], w[1], 0.0],
            [u[2], v[2], w[2], 0.0],
        ];
        let exact = Doubles::three(simd, &exact);
        let l = [exact[0].rounded(), exact[1].rounded(), exact[2].rounded()];
        let magnitudes = [l[0].abs(), l[1].abs(), l[2].abs()];
        let (mut from_origin, mut distances, mut entering) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for i in 0..3 {
            let (center, offset) = (f64::from(center_world[i]), f64::from(x[3][i]));
            from_origin[i] = center - offset;
            distances[i] = from_origin[i].abs();
            entering[i] = center.abs() + offset.abs();
        }
        let center_local = weighted_sum(exact, from_origin).rounded();

        // Point 3: R, and what bounds its rounding in f64. Lanes are local axes.
        let (mut residual, mut rounding) = (Doubles::splat(simd, 0.0), Doubles::splat(simd, 0.0));
        let (axes, one) = (Doubles::axes(simd), Doubles::splat(simd, 1.0));
        for j in 0..3 {
            let column = wide(x[j]);
            let product = weighted_sum(l, column);
            let bound = weighted_sum(magnitudes, [column[0].abs(), column[1].abs(), column[2].abs()]);
            residual = residual + (product - axes[j]).abs() * extent[j];
            rounding = rounding + (bound + one) * extent[j];
        }
        let residual = residual + (center_local - weighted_sum(l, from_origin)).abs();
        let (offset, origin) = (weighted_sum(magnitudes, distances), weighted_sum(magnitudes, entering));
        let rounding = rounding + offset + origin + center_local.abs();

        let [error_x, error_y, error_z, _] = vertex_error.numbers();
        let moved = weighted_sum(magnitudes, [error_x, error_y, error_z]);
        let scale = magnitudes[0] + magnitudes[1] + magnitudes[2];
        let extent = Doubles::new(simd, &[extent[0], extent[1], extent[2], 0.0]);
        // |c_l| once in point 6; planes of the local box twice the extent in point 7.
        let box_rounding = (center_local.abs() + extent) * (48.0 * UNIT_ROUNDOFF);
        let floor = (one + scale) * UNDERFLOW_FLOOR;
        let own = (residual + moved + box_rounding + rounding * F64_SLACK + floor).numbers();
        let scale = scale.numbers();
        // The last factor: point 7 relative to the margin itself, and its sum with the ray's part.
        let rounded = |own: f64, more: f64| f32_above((own + more) * (1.0 + 8.0 * UNIT_ROUNDOFF));
        let (excess, error) = (&inputs.excess, &inputs.posed_error);
        let per_distance = |k: usize| f32_above(f64::from(RAY_ERROR) * scale[k]);
        let [l0, l1, l2] = [l[0].to_f32(), l[1].to_f32(), l[2].to_f32()];
        let out = Self {
            linear: [[l0[0], l1[0], l2[0]], [l0[1], l1[1], l2[1]], [l0[2], l1[2], l2[2]]],
            center_world,
            center_local: center_local.to_point(),
            margin_local: [
                rounded(own[0], excess[0]),
                rounded(own[1], excess[1]),
                rounded(own[2], excess[2]),
            ],
            margin_posed: [
                rounded(own[0], error[0]),
                rounded(own[1], error[1]),
                rounded(own[2], error[2]),
            ],
            margin_per_distance: [per_distance(0), per_distance(1), per_distance(2)],
        };
        let [a, b, c] = out.margin_local;
        let [d, e, f] = out.margin_per_distance;
        let finite = a.is_finite() && b.is_finite() && c.is_finite() && d.is_finite() && e.is_finite() && f.is_finite();
        finite.then_some(out)
    }

    /// The ray in local space, with this cluster's margin for it, and the margin for boxes that follow the pose. `t` is the
    /// same in both spaces. The direction's longest component is at least one (point 6).
    #[inline(always)]
    pub(crate) fn enter(&self, origin: [f32; 3], direction: [f32; 3], bounds_world: &Aabb) -> (SlabRay, [f32; 3]) {
        debug_assert!(direction.iter().any(|d| d.abs() >= 1.0), "{direction:?}");
        let from_center: [f32; 3] = std::array::from_fn(|k| origin[k] - self.center_world[k]);
        let product = |v: [f32; 3], k: usize| {
            let row = self.linear[k];
            (row[0] * v[0] + row[1] * v[1]) + row[2] * v[2]
        };
        let far = distance(origin, bounds_world);
        let origin: [f32; 3] = std::array::from_fn(|k| product(from_center, k) + self.center_local[k]);
        // Where the origin, or its distance to a plane, may have overflowed, no plane restricts the ray.
        let with = |own: &[f32; 3], k: usize| {
            if origin[k].abs() <= EXTENT_LIMIT as f32 {
                own[k] + self.margin_per_distance[k] * far
            } else {
                f32::INFINITY
            }
        };
        let ray = SlabRay {
            origin,
            inverse_direction: std::array::from_fn(|k| {
                1.0 / lengthened(product(direction, k), SHORTEST * self.margin_per_distance[k])
            }),
            margin: std::array::from_fn(|k| with(&self.margin_local, k)),
        };
        (ray, std::array::from_fn(|k| with(&self.margin_posed, k)))
    }

    /// What [`Self::enter_lanes`] needs for rays of a bundle: the longest components of their directions are from 2⁻³⁰ to 2³⁰, and
    /// at least `longest`; from where they begin it is at most `far` to any point of the cluster's world box, along each axis.
    /// `None` where numbers could under- or overflow.
    pub(crate) fn bundle(&self, longest: f32, far: f32) -> Option<BundleFrame> {
        let per_distance = &self.margin_per_distance;
        // So that directions, and their inverses, stay between 2⁻¹²⁶ and 2¹²⁶.
        if !per_distance
            .iter()
            .all(|m| (LEAST_SCALE..=1.0 / LEAST_SCALE).contains(m))
        {
            return None;
        }
        let far = far + BUNDLE_FLOOR;
        let margin = |own: &[f32; 3]| std::array::from_fn(|k| own[k] + per_distance[k] * far);
        Some(BundleFrame {
            margin: margin(&self.margin_local),
            margin_posed: margin(&self.margin_posed),
            shortest: per_distance.map(|m| SHORTEST * m * longest),
        })
    }

    /// As [`Self::enter`], for eight rays of a bundle, whose directions need not be scaled.
    #[inline(always)]
    pub(crate) fn enter_lanes<S: Lanes>(
        &self,
        simd: S,
        origin: &[[f32; 8]; 3],
        direction: &[[f32; 8]; 3],
        bundle: &BundleFrame,
        out: &mut SlabLanes,
    ) {
        let mut from_center = [simd.splat8(0.0); 3];
        for k in 0..3 {
            from_center[k] = simd.sub8(simd.load8(&origin[k]), simd.splat8(self.center_world[k]));
        }
        let direction = [
            simd.load8(&direction[0]),
            simd.load8(&direction[1]),
            simd.load8(&direction[2]),
        ];
        for k in 0..3 {
            let moved = product_lanes(simd, &self.linear[k], from_center);
            simd.store8(simd.add8(moved, simd.splat8(self.center_local[k])), &mut out.origin[k]);
            let mut along = [0.0; 8];
            simd.store8(product_lanes(simd, &self.linear[k], direction), &mut along);
            for lane in 0..8 {
                out.inverse_direction[k][lane] = 1.0 / lengthened(along[lane], bundle.shortest[k]);
            }
        }
    }

    /// The largest part of the margin that does not depend on the ray, relative to nothing: local units.
    pub(crate) fn largest_margin(&self) -> f32 {
        self.margin_local.iter().fold(0.0, |largest: f32, m| largest.max(*m))
    }
}

#[inline(always)]
fn lengthened(along: f32, shortest: f32) -> f32 {
    if along.abs() < shortest {
        shortest.copysign(along)
    } else {
        along
    }
}

#[inline(always)]
fn product_lanes<S: Lanes>(simd: S, row: &[f32; 3], [x, y, z]: [S::F8; 3]) -> S::F8 {
    let xy = simd.add8(simd.mul8(simd.splat8(row[0]), x), simd.mul8(simd.splat8(row[1]), y));
    simd.add8(xy, simd.mul8(simd.splat8(row[2]), z))
}
