use glam::{DMat3, DVec3};

/// Sweeps of rotations; a 3 × 3 matrix needs five or six to reach rounding.
const SWEEPS: usize = 16;

/// Columns whose cosine is below this count as orthogonal: the rounding of their dot product.
const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;

/// A matrix as rotation, signed singular values, rotation: `m = u · diag(values) · vᵀ`.
///
/// Guarantee: `u` and `v` are rotations (determinant +1); `|values|` falls; only the last value can be negative, and
/// is where the determinant is. So mirroring shows as a sign, and clamping the values is a continuous operation.
pub(super) struct SignedSvd {
    pub u: DMat3,
    pub values: DVec3,
    pub v: DMat3,
}

/// The signed singular value decomposition, by one-sided Jacobi rotations.
///
/// Plain `f64` arithmetic in a fixed order: the same on every machine.
///
/// Source: Hestenes, *Inversion of Matrices by Biorthogonalization and Related Results*, 1958.
pub(super) fn signed_svd(m: DMat3) -> SignedSvd {
    let mut b = [m.x_axis, m.y_axis, m.z_axis];
    let mut v = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..SWEEPS {
        let mut turned = false;
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (alpha, beta, gamma) = (b[i].dot(b[i]), b[j].dot(b[j]), b[i].dot(b[j]));
            if gamma * gamma <= ORTHOGONAL * ORTHOGONAL * alpha * beta {
                continue;
            }
            turned = true;
            let zeta = (beta - alpha) / (2.0 * gamma);
            let t = if zeta >= 0.0 { 1.0 } else { -1.0 } / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let c = 1.0 / (1.0 + t * t).sqrt();
            let s = c * t;
            for columns in [&mut b, &mut v] {
                let (x, y) = (columns[i], columns[j]);
                columns[i] = x * c - y * s;
                columns[j] = x * s + y * c;
            }
        }
        if !turned {
            break;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| b[*j].length_squared().total_cmp(&b[*i].length_squared()));
    let [b0, b1, b2] = order.map(|i| b[i]);
    let [v0, v1, _] = order.map(|i| v[i]);
    // The last column is turned so that v stays a rotation; the sign goes into the value.
    let v2 = v0.cross(v1);
    let sign = if v2.dot(v[order[2]]) >= 0.0 { 1.0 } else { -1.0 };
    let u0 = b0.try_normalize().unwrap_or(DVec3::X);
    let u1 = (b1 - u0 * u0.dot(b1))
        .try_normalize()
        .unwrap_or_else(|| u0.any_orthonormal_vector());
    let u2 = u0.cross(u1);
    SignedSvd {
        u: DMat3::from_cols(u0, u1, u2),
        values: DVec3::new(b0.dot(u0), b1.dot(u1), sign * b2.dot(u2)),
        v: DMat3::from_cols(v0, v1, v2),
    }
}

impl SignedSvd {
    /// The rotation nearest to the matrix.
    pub(super) fn rotation(&self) -> DMat3 {
        self.u * self.v.transpose()
    }

    /// The matrix with its singular values replaced.
    pub(super) fn with_values(&self, values: DVec3) -> DMat3 {
        self.u * DMat3::from_diagonal(values) * self.v.transpose()
    }
}

/// Eigenvalues, falling, and eigenvectors (a rotation's columns) of a symmetric matrix without negative eigenvalues.
pub(super) fn eigen_of_covariance(m: DMat3) -> (DVec3, DMat3) {
    let svd = signed_svd(m);
    (svd.values.abs(), svd.v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_rotations_and_multiply_to_the_matrix() {
        let mut random = fastrand::Rng::with_seed(7);
        for round in 0..2000 {
            let mut m = DMat3::from_cols_array(&std::array::from_fn(|_| random.f64() - 0.5));
            match round % 5 {
                1 => m.z_axis = m.x_axis,
                2 => m = DMat3::from_cols(m.x_axis, m.x_axis * 2.0, m.x_axis * 1e-9),
                3 => m.z_axis *= 1e-12,
                4 => m = m * m.transpose(),
                _ => {}
            }
            if round == 10 {
                m = DMat3::ZERO;
            }
            let svd = signed_svd(m);
            let rebuilt = svd.with_values(svd.values);
            // Sixteen sweeps of rotations, each good to a few roundings.
            let allowed = 1e-14;
            for k in 0..3 {
                assert!(
                    (rebuilt.col(k) - m.col(k)).length() <= allowed,
                    "round {round}: {m} {rebuilt}"
                );
            }
            for rotation in [svd.u, svd.v] {
                assert!((rotation.determinant() - 1.0).abs() <= allowed, "round {round}");
                assert!(
                    (rotation * rotation.transpose() - DMat3::IDENTITY)
                        .to_cols_array()
                        .iter()
                        .all(|x| x.abs() <= allowed)
                );
            }
            assert!(
                svd.values.x >= svd.values.y && svd.values.y >= svd.values.z.abs() - allowed,
                "round {round}"
            );
        }
    }
}
