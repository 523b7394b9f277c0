use super::{Four, Lanes};
use std::ops::{Add, Mul, Sub};

/// Four `f64` of a set of instructions, with the operators of numbers; or three, and one that means nothing.
///
/// Compilers make single numbers of what is written as [`four`](super::four()) where a chain of sums stays in registers.
#[derive(Clone, Copy)]
pub(crate) struct Doubles<S: Lanes> {
    simd: S,
    lanes: S::D4,
}

impl<S: Lanes> Doubles<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, numbers: &Four) -> Self {
        let lanes = simd.load4_f64(numbers);
        Self { simd, lanes }
    }

    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        let lanes = simd.splat4_f64(x);
        Self { simd, lanes }
    }

    #[inline(always)]
    pub(crate) fn from_f32(simd: S, numbers: &[f32; 4]) -> Self {
        let lanes = simd.to_f64(simd.load4(numbers));
        Self { simd, lanes }
    }

    /// Each four numbers of an array.
    #[inline(always)]
    pub(crate) fn three(simd: S, [a, b, c]: &[Four; 3]) -> [Self; 3] {
        [Self::new(simd, a), Self::new(simd, b), Self::new(simd, c)]
    }

    /// Columns of the identity.
    #[inline(always)]
    pub(crate) fn axes(simd: S) -> [Self; 3] {
        Self::three(
            simd,
            &[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        )
    }

    /// Three numbers, and zero.
    #[inline(always)]
    pub(crate) fn from_point(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self::from_f32(simd, &[x, y, z, 0.0])
    }

    #[inline(always)]
    pub(crate) fn numbers(self) -> Four {
        self.simd.store4_f64(self.lanes)
    }

    /// Each rounded.
    #[inline(always)]
    pub(crate) fn to_f32(self) -> [f32; 4] {
        self.simd.store4(self.simd.to_f32(self.lanes))
    }

    /// The first three, each rounded.
    #[inline(always)]
    pub(crate) fn to_point(self) -> [f32; 3] {
        let [x, y, z, _] = self.to_f32();
        [x, y, z]
    }

    /// What is left of each once it is an `f32`.
    #[inline(always)]
    pub(crate) fn rounded(self) -> Self {
        let lanes = self.simd.to_f64(self.simd.to_f32(self.lanes));
        Self { lanes, ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        let lanes = self.simd.abs4_f64(self.lanes);
        Self { lanes, ..self }
    }

    /// Of numbers that do not compare, `other`'s.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let lanes = self.simd.max4_f64(self.lanes, other.lanes);
        Self { lanes, ..self }
    }

    #[inline(always)]
    pub(crate) fn over(self, divisor: f64) -> Self {
        let lanes = self.simd.div4_f64(self.lanes, self.simd.splat4_f64(divisor));
        Self { lanes, ..self }
    }
}

impl<S: Lanes> Add for Doubles<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let lanes = self.simd.add4_f64(self.lanes, other.lanes);
        Self { lanes, ..self }
    }
}

impl<S: Lanes> Sub for Doubles<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let lanes = self.simd.sub4_f64(self.lanes, other.lanes);
        Self { lanes, ..self }
    }
}

impl<S: Lanes> Mul for Doubles<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let lanes = self.simd.mul4_f64(self.lanes, other.lanes);
        Self { lanes, ..self }
    }
}

impl<S: Lanes> Mul<f64> for Doubles<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::splat(self.simd, factor)
    }
}

/// `Σ columns·v`, added from the left.
#[inline(always)]
pub(crate) fn weighted_sum<S: Lanes>([x, y, z]: [Doubles<S>; 3], [a, b, c]: [f64; 3]) -> Doubles<S> {
    x * a + y * b + z * c
}
