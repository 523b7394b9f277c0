use crate::affine64::wide;
use restpose_formats::geom::Affine;

/// Cluster frames whose linear part has a greater condition number (Frobenius) are not inverted.
///
/// The margin grows with the condition number; at 2¹⁶ it reaches a tenth of the cluster's own size and tree traversal
/// stops paying.
const CONDITION_LIMIT: f64 = 65_536.0;

/// Cluster frames that scale by more than this, or by less than its inverse, are not inverted: products with their
/// entries could underflow to nothing and take the relative error bounds with them.
const SCALE_LIMIT: f64 = (1u64 << 60) as f64;

/// The inverse of a map's linear part in `f64`, rows first, if the map is usable as a cluster frame: finite, within
/// the limits of scale and condition.
///
/// The baker asks the same function which samples bound a cluster's boxes, so baker and runtime agree on which poses
/// the tree serves; for the others the runtime refits the tree.
#[inline(always)]
#[must_use]
pub fn invert_frame(frame: &Affine) -> Option<[[f64; 3]; 3]> {
    let [c0, c1, c2, _] = frame.columns;
    let [c0, c1, c2] = [wide(c0), wide(c1), wide(c2)];
    let mut inverse = [cross(c1, c2), cross(c2, c0), cross(c0, c1)];
    let determinant = c0[0] * inverse[0][0] + c0[1] * inverse[0][1] + c0[2] * inverse[0][2];
    let scale = 1.0 / determinant;
    for x in inverse.as_flattened_mut() {
        *x *= scale;
    }
    let (forward, backward) = (squared_norm(&[c0, c1, c2]), squared_norm(&inverse));
    let usable = frame.is_finite()
        && forward * backward <= CONDITION_LIMIT * CONDITION_LIMIT
        && forward <= SCALE_LIMIT * SCALE_LIMIT
        && backward <= SCALE_LIMIT * SCALE_LIMIT;
    usable.then_some(inverse)
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn squared_norm(m: &[[f64; 3]; 3]) -> f64 {
    let mut sums = [0.0; 3];
    for row in m {
        for k in 0..3 {
            sums[k] += row[k] * row[k];
        }
    }
    sums[0] + sums[1] + sums[2]
}
