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
#[inline]
#[must_use]
pub fn invert_frame(frame: &Affine) -> Option<[[f64; 3]; 3]> {
    let [c0, c1, c2] = [0, 1, 2].map(|k: usize| frame.columns[k].map(f64::from));
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let rows = [cross(c1, c2), cross(c2, c0), cross(c0, c1)];
    let determinant = c0[0] * rows[0][0] + c0[1] * rows[0][1] + c0[2] * rows[0][2];
    let inverse = rows.map(|row| row.map(|x| x / determinant));
    let norm = |m: [[f64; 3]; 3]| m.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
    let (forward, backward) = (norm([c0, c1, c2]), norm(inverse));
    let usable =
        frame.is_finite() && forward * backward <= CONDITION_LIMIT && forward <= SCALE_LIMIT && backward <= SCALE_LIMIT;
    usable.then_some(inverse)
}
