//! Directed rounding. Every outward step in the project is one of these functions, so that a conservative
//! computation reads as one and can be checked with zero tolerance.
//!
//! Based on: Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., §3.1 (γₙ).

/// Unit roundoff of `f32`, 2⁻²⁴: one operation rounded to nearest is off by at most this, relatively.
pub const UNIT_ROUNDOFF: f64 = 1.0 / (1u64 << 24) as f64;

/// γₙ = n·u / (1 − n·u) with u = 2⁻²⁴: bound of the relative error that `n` successive `f32` roundings build up.
///
/// Guarantee: an upper bound for `n` < 2²⁰; the `f64` rounding of the bound itself is covered by a factor 1 + 2⁻⁵⁰.
#[must_use]
pub fn gamma(n: u32) -> f64 {
    let nu = f64::from(n) * UNIT_ROUNDOFF;
    nu / (1.0 - nu) * (1.0 + 4.0 * f64::EPSILON)
}

/// The largest `f32` that is not above `x`. NaN stays NaN.
#[inline]
#[must_use]
pub fn f32_below(x: f64) -> f32 {
    let nearest = x as f32;
    of_rank(rank(nearest) - i32::from(f64::from(nearest) > x))
}

/// The smallest `f32` that is not below `x`. NaN stays NaN.
#[inline]
#[must_use]
pub fn f32_above(x: f64) -> f32 {
    let nearest = x as f32;
    of_rank(rank(nearest) + i32::from(f64::from(nearest) < x))
}

/// Rises by one from each `f32` to the next. Which way numbers were rounded is as good as random, so a branch on that costs more
/// than all of this.
#[inline]
fn rank(x: f32) -> i32 {
    flip_if_negative(x.to_bits().cast_signed())
}

#[inline]
fn of_rank(rank: i32) -> f32 {
    f32::from_bits(flip_if_negative(rank).cast_unsigned())
}

/// Turns the order of the negative numbers round; its own inverse.
#[inline]
fn flip_if_negative(bits: i32) -> i32 {
    bits ^ ((bits >> 31) & i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directed_conversion_brackets_the_value() {
        let third = 1.0f64 / 3.0;
        for x in [third, -third, 1e-50, -1e-50, 1e39, -1e39, 0.0, 1.0, 16_777_217.0] {
            let (below, above) = (f32_below(x), f32_above(x));
            assert!(f64::from(below) <= x && x <= f64::from(above), "{x}: {below} {above}");
            assert!(
                below == above || below.next_up() == above,
                "{x}: {below} {above} are not neighbours"
            );
        }
    }

    #[test]
    fn directed_conversion_takes_the_neighbour_or_none() {
        let special = [
            0,
            1,
            0x007F_FFFF,
            0x0080_0000,
            0x3F80_0000,
            0x7F7F_FFFF,
            0x7F80_0000,
            0x7FC0_0000,
        ];
        let numbers = special.into_iter().chain((0..1 << 31).step_by(40_009));
        for bits in numbers.flat_map(|bits| [bits, bits | 1 << 31]) {
            let exact = f32::from_bits(bits);
            let wide = f64::from(exact);
            assert_eq!(f32_below(wide).to_bits(), exact.to_bits());
            assert_eq!(f32_above(wide).to_bits(), exact.to_bits());
            if exact.is_finite() {
                assert_eq!(f32_below(wide.next_down()).to_bits(), exact.next_down().to_bits());
                assert_eq!(f32_above(wide.next_up()).to_bits(), exact.next_up().to_bits());
            }
        }
    }

    #[test]
    fn gamma_is_above_n_unit_roundoffs() {
        for n in [1, 2, 3, 10, 1000] {
            assert!(gamma(n) > f64::from(n) * UNIT_ROUNDOFF);
            assert!(gamma(n) < f64::from(n) * UNIT_ROUNDOFF * 1.001);
        }
    }
}
