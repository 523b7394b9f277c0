use super::{EXTENT_LIMIT, F64_SLACK, FrameInputs, SlabRay, UNDERFLOW_FLOOR, slab_ray::distance};
use crate::{
    simd::{Four, four},
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

impl LocalFrame {
    /// `None` where numbers overflow. The inverse has rows; `extent` bounds the magnitudes in the local box, with the excess;
    /// `vertex_error` is what points 1 and 2 add to in world space, where `bounds_world` holds the cluster.
    #[inline(always)]
    pub(super) fn new(
        inputs: &FrameInputs,
        [u, v, w]: &[[f64; 3]; 3],
        extent: [f64; 3],
        vertex_error: Four,
        bounds_world: &Aabb,
    ) -> Option<Self> {
        let x = inputs.frame.columns();
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
        let mut l = [[0.0; 4]; 3];
        for i in 0..3 {
            l[i] = four(|k| f64::from(exact[i][k] as f32));
        }
        let (mut from_origin, mut entering) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            let center = f64::from(center_world[i]);
            from_origin[i] = center - x[3][i];
            entering[i] = center.abs() + x[3][i].abs();
        }
        let center_local = sum(&exact, &from_origin);
        let center_local = four(|k| f64::from(center_local[k] as f32));

        // Point 3: R, and what bounds its rounding in f64. Lanes are local axes.
        let (mut residual, mut rounding) = ([0.0; 4], [0.0; 4]);
        for j in 0..3 {
            let column = [x[j][0], x[j][1], x[j][2]];
            let (product, bound) = (sum(&l, &column), bound(&l, &column));
            let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]][j];
            residual = four(|k| residual[k] + (product[k] - identity[k]).abs() * extent[j]);
            rounding = four(|k| rounding[k] + (bound[k] + 1.0) * extent[j]);
        }
        let offset = sum(&l, &from_origin);
        let residual = four(|k| residual[k] + (center_local[k] - offset[k]).abs());
        let (offset, origin) = (bound(&l, &from_origin), bound(&l, &entering));
        let rounding = four(|k| rounding[k] + offset[k] + origin[k] + center_local[k].abs());

        let moved = bound(&l, &[vertex_error[0], vertex_error[1], vertex_error[2]]);
        let scale = bound(&l, &[1.0; 3]);
        let extent = [extent[0], extent[1], extent[2], 0.0];
        // |c_l| once in point 6; planes of the local box twice the extent in point 7.
        let box_rounding = four(|k| 32.0 * UNIT_ROUNDOFF * (center_local[k].abs() + extent[k]));
        let own = four(|k| {
            let floor = UNDERFLOW_FLOOR * (1.0 + scale[k]);
            residual[k] + moved[k] + box_rounding[k] + F64_SLACK * rounding[k] + floor
        });
        // The last factor: point 7 relative to the margin itself, and its sum with the ray's part.
        let rounded = |own: f64, more: f64| f32_above((own + more) * (1.0 + 8.0 * UNIT_ROUNDOFF));
        let (excess, error) = (&inputs.excess, &inputs.posed_error);
        let per_distance = |k: usize| f32_above(f64::from(RAY_ERROR) * scale[k]);
        let out = Self {
            linear: [
                [l[0][0] as f32, l[1][0] as f32, l[2][0] as f32],
                [l[0][1] as f32, l[1][1] as f32, l[2][1] as f32],
                [l[0][2] as f32, l[1][2] as f32, l[2][2] as f32],
            ],
            center_world,
            center_local: [center_local[0] as f32, center_local[1] as f32, center_local[2] as f32],
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
    #[inline]
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
                let (along, shortest) = (product(direction, k), SHORTEST * self.margin_per_distance[k]);
                1.0 / if along.abs() < shortest {
                    shortest.copysign(along)
                } else {
                    along
                }
            }),
            margin: std::array::from_fn(|k| with(&self.margin_local, k)),
        };
        (ray, std::array::from_fn(|k| with(&self.margin_posed, k)))
    }

    /// The largest part of the margin that does not depend on the ray, relative to nothing: local units.
    pub(crate) fn largest_margin(&self) -> f32 {
        self.margin_local.iter().fold(0.0, |largest: f32, m| largest.max(*m))
    }
}

/// `Σ columns·v`.
#[inline(always)]
fn sum([x, y, z]: &[Four; 3], v: &[f64; 3]) -> Four {
    four(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
}

/// `Σ |columns|·|v|`, which bounds its magnitude and its rounding.
#[inline(always)]
fn bound([x, y, z]: &[Four; 3], v: &[f64; 3]) -> Four {
    four(|k| x[k].abs() * v[0].abs() + y[k].abs() * v[1].abs() + z[k].abs() * v[2].abs())
}
