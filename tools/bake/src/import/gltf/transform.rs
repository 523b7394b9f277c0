/// A matrix may be taken apart when its axes, scaled to unit length, are this close to perpendicular: the largest
/// absolute dot product. Exporters write `f32`, so exact frames come with errors of a few 1e-7.
const SHEAR_TOLERANCE: f64 = 1e-5;

/// The bottom row of an affine matrix may differ from 0 0 0 1 by this much: exporters invert and multiply in `f32`
/// over chains of bones, and no reader uses that row.
const BOTTOM_ROW_TOLERANCE: f64 = 1e-3;

/// Four columns of three, and whether the bottom row was exactly 0 0 0 1.
///
/// Shape: `matrix` is column-major 4 × 4.
///
/// # Errors
/// A sentence: the matrix is not affine.
pub(super) fn affine(matrix: &[f64; 16]) -> Result<([[f64; 3]; 4], bool), String> {
    let bottom = [matrix[3], matrix[7], matrix[11], matrix[15]];
    let deviation = [0.0, 0.0, 0.0, 1.0]
        .iter()
        .zip(bottom)
        .map(|(want, found)| (found - want).abs());
    let deviation = deviation.fold(0.0, f64::max);
    if deviation > BOTTOM_ROW_TOLERANCE {
        return Err(format!("the matrix has the bottom row {bottom:?}; expected 0, 0, 0, 1"));
    }
    let column = |k: usize| [matrix[4 * k], matrix[4 * k + 1], matrix[4 * k + 2]];
    Ok(([column(0), column(1), column(2), column(3)], deviation == 0.0))
}

/// Rotation (quaternion x y z w) and scale of an affine map, whose product they are in this order.
///
/// A mirroring map gets a negative x scale.
///
/// # Errors
/// A sentence: the map is flat or sheared.
pub(super) fn rotation_and_scale(columns: &[[f64; 3]; 4]) -> Result<([f64; 4], [f64; 3]), String> {
    let [a, b, c, _] = *columns;
    let mut scale = [a, b, c].map(|axis| dot(axis, axis).sqrt());
    if scale.contains(&0.0) {
        return Err("the matrix is flat, so it has no rotation".into());
    }
    if dot(cross(a, b), c) < 0.0 {
        scale[0] = -scale[0];
    }
    let [x, y, z]: [[f64; 3]; 3] = std::array::from_fn(|k| columns[k].map(|entry| entry / scale[k]));
    let shear = dot(x, y).abs().max(dot(y, z).abs()).max(dot(z, x).abs());
    if shear > SHEAR_TOLERANCE {
        return Err("the matrix is sheared".into());
    }
    Ok((quaternion([x, y, z]), scale))
}

/// The quaternion x y z w of the same direction and length one, or nothing when it has none.
pub(super) fn normalized(quaternion: [f64; 4]) -> Option<[f64; 4]> {
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length.is_normal()).then(|| quaternion.map(|x| x / length))
}

/// Of a rotation matrix given by its columns. The largest of the four components is found first, so that nothing
/// cancels.
///
/// Based on: Shepperd 1978, "Quaternion from rotation matrix".
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> [f64; 4] {
    let candidates = [
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
        1.0 + x[0] + y[1] + z[2],
    ];
    let largest = (0..4).fold(3, |best, k| if candidates[k] > candidates[best] { k } else { best });
    let twice = candidates[largest].sqrt();
    let over = 0.5 / twice;
    let (xy, yz, zx) = ((x[1] + y[0]) * over, (y[2] + z[1]) * over, (z[0] + x[2]) * over);
    let (wx, wy, wz) = ((y[2] - z[1]) * over, (z[0] - x[2]) * over, (x[1] - y[0]) * over);
    let half = 0.5 * twice;
    match largest {
        0 => [half, xy, zx, wx],
        1 => [xy, half, yz, wy],
        2 => [zx, yz, half, wz],
        _ => [wx, wy, wz, half],
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(q: [f64; 4], s: [f64; 3]) -> [[f64; 3]; 4] {
        let [x, y, z, w] = q;
        [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + z * w),
                2.0 * (x * z - y * w),
            ]
            .map(|e| e * s[0]),
            [
                2.0 * (x * y - z * w),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + x * w),
            ]
            .map(|e| e * s[1]),
            [
                2.0 * (x * z + y * w),
                2.0 * (y * z - x * w),
                1.0 - 2.0 * (x * x + y * y),
            ]
            .map(|e| e * s[2]),
            [7.0, 8.0, 9.0],
        ]
    }

    #[test]
    fn a_matrix_equals_the_product_of_its_parts() {
        let rotations = [
            [1.0, 2.0, 3.0, 4.0],
            [9.0, 1.0, -2.0, 0.1],
            [0.1, -9.0, 1.0, 0.0],
            [0.0, 0.3, 8.0, -0.2],
            [0.0, 0.0, 0.0, 1.0],
        ];
        for q in rotations {
            for s in [
                [1.0, 1.0, 1.0],
                [2.0, 0.5, 30.0],
                [-1.0, 1.0, 1.0],
                [-1.0, -2.0, -3.0],
                [1e-8, 1e-8, 1e-8],
            ] {
                let matrix = columns(normalized(q).unwrap(), s);
                let (rotation, scale) = rotation_and_scale(&matrix).unwrap();
                let again = columns(rotation, scale);
                for (a, b) in matrix.iter().flatten().zip(again.iter().flatten()) {
                    // Some forty f64 operations on numbers up to 30.
                    assert!((a - b).abs() < 1e-13 * 30.0, "{q:?} {s:?}: {matrix:?} {again:?}");
                }
            }
        }
    }

    #[test]
    fn flat_and_sheared_matrices_are_refused() {
        assert!(rotation_and_scale(&columns([0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 1.0])).is_err());
        let mut sheared = columns([0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0]);
        sheared[1][0] = 0.01;
        assert!(rotation_and_scale(&sheared).is_err());
    }

    #[test]
    fn only_affine_matrices_pass() {
        let mut matrix = [
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0,
        ];
        assert_eq!(affine(&matrix).unwrap().0[3], [5.0, 6.0, 7.0]);
        assert!(affine(&matrix).unwrap().1);
        matrix[15] = 1.000_000_1;
        assert!(!affine(&matrix).unwrap().1);
        matrix[11] = -1.0;
        assert!(affine(&matrix).is_err());
    }
}
