use crate::{Aabb, simd::Lanes};
use restpose_formats::{geom::round::UNIT_ROUNDOFF, rows::ReferenceBoxRow};

/// A lattice, as its planes are taken to local space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalLattice {
    zero: [f32; 3],
    step: [f32; 3],
    margin: [f32; 3],
}

impl LocalLattice {
    /// Widened so that a plane need not be exact: `fl(zero + fl(step·q))` is off by u relative to itself, and so to the sum of both
    /// magnitudes, and by u relative to the product. What is relative to the product is in the margin, where more roundings of it
    /// are counted than there are (`cluster_frame`); four units of the other are more than all roundings of it.
    pub(crate) fn new(zero: [f32; 3], step: [f32; 3], margin: [f32; 3]) -> Self {
        let widened = |k: usize| margin[k] + (4.0 * UNIT_ROUNDOFF) as f32 * zero[k].abs();
        Self {
            zero,
            step,
            margin: std::array::from_fn(widened),
        }
    }

    /// The least and the greatest sides of eight boxes along an axis, in local space. Where a box is nowhere, as one that follows a
    /// pose in which numbers overflow, they are infinite, so that both restrict nothing.
    #[inline(always)]
    pub(super) fn widened<S: Lanes>(&self, simd: S, k: usize, [least, greatest]: [S::F8; 2]) -> [S::F8; 2] {
        let (zero, step) = (simd.splat8(self.zero[k]), simd.splat8(self.step[k]));
        let margin = simd.splat8(self.margin[k]);
        let least = simd.sub8(simd.add8(zero, simd.mul8(least, step)), margin);
        let greatest = simd.add8(simd.add8(zero, simd.mul8(greatest, step)), margin);
        [
            simd.max8(least, simd.splat8(f32::NEG_INFINITY)),
            simd.min8(greatest, simd.splat8(f32::INFINITY)),
        ]
    }

    /// As [`Self::widened`], of one box.
    #[inline]
    pub(crate) fn widened_box(&self, row: &ReferenceBoxRow) -> Aabb {
        let plane = |q: u16, k: usize| self.zero[k] + f32::from(q) * self.step[k];
        Aabb {
            min: std::array::from_fn(|k| plane(row.min[k], k) - self.margin[k]),
            max: std::array::from_fn(|k| plane(row.max[k], k) + self.margin[k]),
        }
    }
}
