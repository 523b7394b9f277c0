//! How the bones of a cluster move against its own in a pose, in `f64`: what is measured against envelopes, and what boxes
//! follow.

use crate::simd::{Four, four};
use restpose_formats::{geom::Affine, rows::ClusterBoneRow};

/// 2⁻⁴⁸: bounds the `f64` roundings of a relative motion, under 32 of 2⁻⁵³, relative to the magnitudes that enter it.
pub(crate) const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// `R = X⁻¹·Xᵢ` for a bone i beside the cluster's own, X: with `E = A − 1` and b, a point p is displaced by `E·p + b`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativeMotion {
    /// Columns of E, of three numbers each.
    pub columns: [Four; 3],
    pub offset: Four,
    /// Bounds the error of each entry of E.
    pub entry_error: f64,
    /// Bounds the error of each entry of b.
    pub offset_error: f64,
}

/// Those of a cluster, in the order of its bones. Scratch: keep one and reuse it.
#[derive(Debug, Default)]
pub(crate) struct RelativeMotions(pub(crate) Vec<RelativeMotion>);

impl RelativeMotions {
    /// `inverse` is what [`invert_frame`](crate::invert_frame) made of the map of bone row `own`; `palette` has no instance
    /// transform in it.
    ///
    /// # Why the errors bound what is left out
    ///
    /// With the computed inverse L, `X⁻¹ = L + (1 − L·X)·X⁻¹`, so `‖1 − L·X‖` bounds the relative error of everything that L
    /// maps ([`inverse_error`]); twice that covers its square. The products have a few roundings of the norms that enter.
    #[inline(always)]
    pub(crate) fn update(
        &mut self,
        cluster_bones: &[ClusterBoneRow],
        own: u32,
        inverse: &[[f64; 3]; 3],
        palette: &[Affine],
    ) {
        self.0.clear();
        self.0.reserve(cluster_bones.len());
        let x = columns(&palette[own as usize]);
        let inverse_norm = norm(inverse.as_flattened());
        let slack = 2.0 * inverse_error(inverse, &x) + ROUNDING;
        let own_offset = norm(&x[3]);
        let [u, v, w] = inverse;
        let turn = [
            [u[0], v[0], w[0], 0.0],
            [u[1], v[1], w[1], 0.0],
            [u[2], v[2], w[2], 0.0],
        ];
        for row in cluster_bones {
            if row.bone == own {
                continue;
            }
            let [a, b, c, d] = columns(&palette[row.bone as usize]);
            let offset = [d[0] - x[3][0], d[1] - x[3][1], d[2] - x[3][2]];
            let mut columns = [turned(&turn, a), turned(&turn, b), turned(&turn, c)];
            for j in 0..3 {
                columns[j][j] -= 1.0;
            }
            let linear = (square(a) + square(b) + square(c)).sqrt();
            self.0.push(RelativeMotion {
                columns,
                offset: turned(&turn, offset),
                entry_error: slack * (inverse_norm * linear + 1.0),
                offset_error: slack * (inverse_norm * (square(d).sqrt() + own_offset)),
            });
        }
    }
}

#[inline(always)]
fn columns(map: &Affine) -> [[f64; 3]; 4] {
    let [x, y, z, offset] = &map.columns;
    let wide = |v: &[f32; 3]| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])];
    [wide(x), wide(y), wide(z), wide(offset)]
}

/// `inverse`, by columns, times v.
#[inline(always)]
fn turned([x, y, z]: &[Four; 3], v: [f64; 3]) -> Four {
    four(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
}

#[inline(always)]
fn square([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}

#[inline(always)]
fn norm(numbers: &[f64]) -> f64 {
    let mut sum = 0.0;
    for x in numbers {
        sum += x * x;
    }
    sum.sqrt()
}

/// `‖L·X − I‖∞` for a computed inverse L, its own rounding included: `X⁻¹ − L = −(L·X − I)·X⁻¹`, so it bounds the
/// relative error of everything that L maps.
#[inline(always)]
fn inverse_error(inverse: &[[f64; 3]; 3], own: &[[f64; 3]; 4]) -> f64 {
    let mut worst = 0.0f64;
    for (k, row) in inverse.iter().enumerate() {
        let mut sum = 0.0;
        for j in 0..3 {
            let (a, b, c) = (row[0] * own[j][0], row[1] * own[j][1], row[2] * own[j][2]);
            let identity = if j == k { 1.0 } else { 0.0 };
            let rounding = ROUNDING * (a.abs() + b.abs() + c.abs() + identity);
            sum += (a + b + c - identity).abs() + rounding;
        }
        worst = worst.max(sum);
    }
    worst
}
