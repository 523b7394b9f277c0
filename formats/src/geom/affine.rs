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
        self.columns.iter().flatten().all(|x| x.is_finite())
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

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}
