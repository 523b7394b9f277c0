//! Vectors of four and eight `f32` and of four `f64`, for each set of instructions that a kernel is compiled for.
//!
//! A kernel is generic over [`Lanes`] and compiled once per [`SimdLevel`]. All levels compute the same bits: the
//! operations are those of IEEE 754 in the same order, nothing is fused. [`Portable`] is always compiled; it is what
//! other machines run and what tests compare with.
//!
//! Everything between a kernel's entry and these operations must be `#[inline(always)]`, and no closure but those that such a
//! function takes and calls in place, as [`four()`] does: what is compiled on its own is compiled without the instructions, and
//! calls each of them as a function (measured: half the speed).

#[cfg(target_arch = "x86_64")]
mod avx2;
mod doubles;
mod four;
mod lanes;
mod portable;
mod prefetch;
#[cfg(test)]
mod tests;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
pub(crate) use doubles::{Doubles, weighted_sum};
pub(crate) use four::{Four, four};
pub(crate) use lanes::Lanes;
pub(crate) use portable::Portable;
pub(crate) use prefetch::prefetch;

/// Which instructions a kernel uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SimdLevel {
    /// Those that every machine of the target has.
    Portable,
    /// AVX2, on x86-64. Elsewhere the same as [`SimdLevel::Portable`], as on machines that lack it.
    Avx2,
}

impl SimdLevel {
    /// The best of this machine.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if Avx2::new().is_some() {
            return Self::Avx2;
        }
        Self::Portable
    }
}
