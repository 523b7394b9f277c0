//! Spherical interpolation of quaternions, four at a time.
//!
//! With θ between the keys, `sin((1 − s)θ)/sin θ` and `sin(sθ)/sin θ` weigh them. Both are smooth in θ², and θ² is in
//! `1 − cos θ`, so that neither needs the angle, nor anything special where it is small:
//! `sin(sθ)/sin θ = s·S((sθ)²)/S(θ²)` with `S(x) = sin(√x)/√x`. The shorter arc has θ ≤ 90°, the range of the polynomials.
//!
//! Their coefficients interpolate the functions in the Chebyshev nodes of the interval, computed with 260 bits and rounded
//! to `f64`. The bounds were found with the rounded ones, at 2001 even steps.
//!
//! Everything is sums, products, quotients and square roots in `f64`, which IEEE 754 rounds alike everywhere, without
//! fused multiplications: the same bits on every platform. Each lane is computed as the others are, so it does not matter
//! which arcs come together.
//!
//! Measured on the fox, 21 arcs and 25 bones, per pose: 1.47 µs by fours, 2.0 µs one by one, where each step waits for the
//! one before; 1.38 µs with polynomials in pairs instead of four of Horner's. No better: 1.43 µs by eights, which do not fit
//! the registers; 1.47 instead of 1.42 µs with a polynomial for `θ/sin θ`, of degree 19 as well, instead of a division.

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::simd::{Four, SimdLevel, four};

/// Arcs that are computed together.
pub(super) const LANES: usize = 4;

/// θ²/y for y = 1 − cos θ in [0, 1], within 2⁻⁵⁶ relative to it.
const SQUARE: [f64; 20] = [
    2.0,
    0.33333333333334236,
    0.08888888888769016,
    0.02857142863437903,
    0.010158728414596523,
    0.0038480332967846653,
    0.0015219571595420725,
    0.0006241964137401375,
    0.0002451459418574807,
    0.0001745148861685395,
    -0.0001592831331954223,
    0.0005395277675839511,
    -0.0009917748430027734,
    0.0014939102239561115,
    -0.0016927385758383567,
    0.001449363304895375,
    -0.0009020060892722442,
    0.0003882345560479792,
    -0.00010348658822150871,
    1.3126681285547233e-5,
];

/// sin(√x)/√x for x in [0, (π/2)²], within 2⁻⁵¹ relative to it. The constant is set to one, so that equal keys are met.
const SINE: [f64; 8] = [
    1.0,
    -0.16666666666666072,
    0.008333333333282756,
    -0.00019841269824861897,
    2.7557316609073673e-6,
    -2.505188194671259e-8,
    1.6048168318165643e-10,
    -7.374387503862757e-13,
];

/// Interpolates from `a` to `b` along the shorter arc; `s` is the part of the way, 0 to 1. Components come first, then
/// lanes: x, y, z, w of four quaternions.
///
/// Keys are finite `f32` numbers, of any length; without one they count as the identity. The arc is the one of positive
/// `((a₀b₀ + a₁b₁) + a₂b₂) + a₃b₃`, as rounded: the baker bounds the same one.
///
/// The result is a unit quaternion, off by 2⁻⁴⁷ at most. With u = 2⁻⁵³: `y` is off by 15u, θ² by 70u, and by that each
/// weight by 14u relative to it; the polynomials, the lengths and the products add 24u; weights sum to at most √2.
/// Found in 60 000 random arcs, with 220 bits: 8u.
// In place LLVM tears the lanes apart to fit what surrounds them.
#[inline(never)]
pub(super) fn slerp(level: SimdLevel, a: &[Four; 4], b: &[Four; 4], s: &Four) -> [Four; 4] {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(_)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(a: &[Four; 4], b: &[Four; 4], s: &Four) -> [Four; 4] {
            interpolated(a, b, s)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(a, b, s) };
    }
    interpolated(a, b, s)
}

#[inline(always)]
fn interpolated(a: &[Four; 4], b: &[Four; 4], s: &Four) -> [Four; 4] {
    let (a, b) = (with_length(a), with_length(b));
    let (from_length, to_length) = (inverse_length(&a), inverse_length(&b));
    let dot = dot(&a, &b);
    let y = four(|k| 1.0 - dot[k].abs() * (from_length[k] * to_length[k]));
    let square = polynomial(&SQUARE, y);
    let square = four(|k| y[k] * square[k]);
    let whole = polynomial(&SINE, square);
    let whole = four(|k| 1.0 / whole[k]);
    let rest = four(|k| 1.0 - s[k]);
    let from = polynomial(&SINE, four(|k| rest[k] * rest[k] * square[k]));
    let from = four(|k| from[k] * rest[k] * (from_length[k] * whole[k]));
    let to = polynomial(&SINE, four(|k| s[k] * s[k] * square[k]));
    let to = four(|k| to[k] * s[k] * (to_length[k] * whole[k]));
    let to = four(|k| if dot[k] < 0.0 { -to[k] } else { to[k] });
    let component = |i: usize| four(|k| from[k] * a[i][k] + to[k] * b[i][k]);
    [component(0), component(1), component(2), component(3)]
}

/// The identity where a quaternion is zero. Squares of finite `f32` neither vanish nor overflow in `f64`.
#[inline(always)]
fn with_length(q: &[Four; 4]) -> [Four; 4] {
    let square = dot(q, q);
    let w = four(|k| if square[k] == 0.0 { 1.0 } else { q[3][k] });
    [q[0], q[1], q[2], w]
}

#[inline(always)]
fn inverse_length(q: &[Four; 4]) -> Four {
    let square = dot(q, q);
    four(|k| 1.0 / square[k].sqrt())
}

#[inline(always)]
fn dot(a: &[Four; 4], b: &[Four; 4]) -> Four {
    four(|k| a[0][k] * b[0][k] + a[1][k] * b[1][k] + a[2][k] * b[2][k] + a[3][k] * b[3][k])
}

/// Σ cᵢxⁱ, by fours: within them in pairs, which do not wait for each other, then from the highest to the lowest.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: Four) -> Four {
    let x2 = four(|k| x[k] * x[k]);
    let x4 = four(|k| x2[k] * x2[k]);
    let (fours, _) = c.as_chunks::<4>();
    let some = |c: &[f64; 4]| four(|k| (c[0] + x[k] * c[1]) + x2[k] * (c[2] + x[k] * c[3]));
    let add = |sum: Four, next: Four| four(|k| next[k] + x4[k] * sum[k]);
    fours.iter().rev().map(some).reduce(add).unwrap_or_default()
}

#[cfg(test)]
mod tests;
