use bytemuck::{Pod, Zeroable};

/// An affine map of space: `x ↦ x₀·columns[0] + x₁·columns[1] + x₂·columns[2] + columns[3]`.
///
/// Shape: four columns of three, the upper three rows of glTF's column-major 4 × 4 matrix.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Affine {
    /// Images of the x, y and z axes, then the translation.
    pub columns: [[f32; 3]; 4],
}

impl Affine {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]],
    };

    /// A pure translation.
    #[must_use]
    pub const fn from_translation(translation: [f32; 3]) -> Self {
        let mut out = Self::IDENTITY;
        out.columns[3] = translation;
        out
    }

    /// True when all twelve entries are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        // Without a branch per number, which eight compare at once.
        let mut all = true;
        for x in self.columns.as_flattened() {
            all &= x.is_finite();
        }
        all
    }

    /// The image of `point`, rounded in this order: `((c₀x + c₁y) + c₂z) + c₃`.
    #[inline]
    #[must_use]
    pub fn transform_point(&self, point: [f32; 3]) -> [f32; 3] {
        let [c0, c1, c2, c3] = self.columns;
        let row = |k: usize| ((c0[k] * point[0] + c1[k] * point[1]) + c2[k] * point[2]) + c3[k];
        [row(0), row(1), row(2)]
    }
}

/// `a * b` is `a` after `b`, each entry summed in `f64` and rounded once.
impl std::ops::Mul for Affine {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let entry = |j: usize, k: usize| {
            let product = |i: usize| f64::from(self.columns[i][k]) * f64::from(other.columns[j][i]);
            let offset = if j == 3 { f64::from(self.columns[3][k]) } else { 0.0 };
            (product(0) + product(1) + product(2) + offset) as f32
        };
        Self {
            columns: std::array::from_fn(|j| std::array::from_fn(|k| entry(j, k))),
        }
    }
}

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_maps_as_its_factors_do_one_after_the_other() {
        // A quarter turn about z, then a shift; every number is exact.
        let turn = Affine {
            columns: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0; 3]],
        };
        let shift = Affine::from_translation([10.0, 20.0, 30.0]);
        let point = [1.0, 2.0, 3.0];
        assert_eq!((shift * turn).transform_point(point), [8.0, 21.0, 36.0]);
        assert_eq!(
            (turn * shift).transform_point(point),
            turn.transform_point(shift.transform_point(point))
        );
        assert_eq!(Affine::IDENTITY * turn, turn);
    }
}
