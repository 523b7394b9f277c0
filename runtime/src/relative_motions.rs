//! How the bones of a cluster move against its own in a pose, in `f64`: what is measured against envelopes, and what boxes
//! follow.

use restpose_formats::{geom::Affine, rows::ClusterBoneRow};

/// 2⁻⁴⁸: bounds the `f64` roundings of a relative motion, under 32 of 2⁻⁵³, relative to the magnitudes that enter it.
pub(crate) const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// `R = X⁻¹·Xᵢ` for a bone i beside the cluster's own, X: with `E = A − 1` and b, a point p is displaced by `E·p + b`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativeMotion {
    /// Columns of E.
    pub columns: [[f64; 3]; 3],
    pub offset: [f64; 3],
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
    pub(crate) fn update(
        &mut self,
        cluster_bones: &[ClusterBoneRow],
        own: u32,
        inverse: &[[f64; 3]; 3],
        palette: &[Affine],
    ) {
        self.0.clear();
        let x = columns(&palette[own as usize]);
        let inverse_norm = norm(inverse.as_flattened());
        let slack = 2.0 * inverse_error(inverse, &x) + ROUNDING;
        let own_offset = norm(&x[3]);
        let others = cluster_bones.iter().filter(|row| row.bone != own);
        self.0.extend(others.map(|row| {
            let other = columns(&palette[row.bone as usize]);
            let mut out = RelativeMotion {
                columns: [[0.0; 3]; 3],
                offset: turned(inverse, [0, 1, 2].map(|i| other[3][i] - x[3][i])),
                entry_error: slack * (inverse_norm * norm(other[..3].as_flattened()) + 1.0),
                offset_error: slack * (inverse_norm * (norm(&other[3]) + own_offset)),
            };
            for j in 0..3 {
                out.columns[j] = turned(inverse, other[j]);
                out.columns[j][j] -= 1.0;
            }
            out
        }));
    }
}

#[inline]
fn columns(map: &Affine) -> [[f64; 3]; 4] {
    let [x, y, z, offset] = &map.columns;
    let wide = |v: &[f32; 3]| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])];
    [wide(x), wide(y), wide(z), wide(offset)]
}

#[inline]
fn turned(inverse: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = inverse;
    let row = |row: &[f64; 3]| row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
    [row(x), row(y), row(z)]
}

fn norm(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `‖L·X − I‖∞` for a computed inverse L, its own rounding included: `X⁻¹ − L = −(L·X − I)·X⁻¹`, so it bounds the
/// relative error of everything that L maps.
fn inverse_error(inverse: &[[f64; 3]; 3], own: &[[f64; 3]; 4]) -> f64 {
    inverse.iter().enumerate().fold(0.0, |worst, (k, row)| {
        let sum: f64 = (0..3)
            .map(|j| {
                let products: [f64; 3] = std::array::from_fn(|i| row[i] * own[j][i]);
                let identity = if j == k { 1.0 } else { 0.0 };
                let rounding = ROUNDING * (products.iter().map(|p| p.abs()).sum::<f64>() + identity);
                (products.iter().sum::<f64>() - identity).abs() + rounding
            })
            .sum();
        f64::max(worst, sum)
    })
}
