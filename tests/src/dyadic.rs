use num_bigint::{BigInt, Sign};
use std::{
    cmp::Ordering,
    ops::{Add, Mul, Neg, Sub},
};

/// `mantissa·2^exponent`: what sums, differences and products of floating-point numbers are, exactly.
#[derive(Clone, Debug)]
pub struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    /// Zero.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            mantissa: BigInt::ZERO,
            exponent: 0,
        }
    }

    /// The magnitude.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.is_negative() { -self } else { self.clone() }
    }

    /// Whether it is below zero.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        self.mantissa.sign() == Sign::Minus
    }

    /// Whether it is zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.mantissa.sign() == Sign::NoSign
    }

    /// Both mantissas with the smaller exponent.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        let exponent = self.exponent.min(other.exponent);
        let [a, b] = [self, other].map(|x| &x.mantissa << (x.exponent - exponent));
        (a, b, exponent)
    }
}

impl From<f64> for Dyadic {
    /// # Panics
    /// When the number is not finite.
    fn from(x: f64) -> Self {
        assert!(x.is_finite(), "{x} has no value");
        let bits = x.to_bits();
        let (stored, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
        // A subnormal number has the exponent of the least normal ones, and no leading bit.
        let mantissa = if stored == 0 { fraction } else { fraction | 1 << 52 } as i64;
        let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
        let mantissa = mantissa >> zeros;
        Self {
            mantissa: BigInt::from(if x < 0.0 { -mantissa } else { mantissa }),
            exponent: stored.max(1) - 1075 + i64::from(zeros),
        }
    }
}

impl From<f32> for Dyadic {
    fn from(x: f32) -> Self {
        Self::from(f64::from(x))
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;

    fn add(self, other: &Dyadic) -> Dyadic {
        if self.is_zero() || other.is_zero() {
            // The exponent of a zero says nothing.
            return if self.is_zero() { other } else { self }.clone();
        }
        let (a, b, exponent) = self.aligned(other);
        let mantissa = a + b;
        Dyadic { mantissa, exponent }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;

    fn neg(self) -> Dyadic {
        Dyadic {
            mantissa: -&self.mantissa,
            exponent: self.exponent,
        }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;

    fn sub(self, other: &Dyadic) -> Dyadic {
        self + &-other
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;

    fn mul(self, other: &Dyadic) -> Dyadic {
        Dyadic {
            mantissa: &self.mantissa * &other.mantissa,
            exponent: self.exponent + other.exponent,
        }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        (self - other).mantissa.sign().cmp(&Sign::NoSign)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against integers of 128 bits, which hold these exactly.
    #[test]
    fn sums_and_products_are_exact() {
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..10_000 {
            let mut number = || (random.i64(-(1 << 40)..1 << 40), random.i32(-8..8));
            let ((a, i), (b, j)) = (number(), number());
            let dyadic = |x: i64, shift: i32| Dyadic::from(x as f64 * 2f64.powi(shift));
            let whole = |x: i64, shift: i32| i128::from(x) << (shift + 8);
            let (x, y) = (dyadic(a, i), dyadic(b, j));
            let exact = |x: i128, shift: i64| Dyadic {
                mantissa: BigInt::from(x),
                exponent: shift,
            };
            assert_eq!(&x + &y, exact(whole(a, i) + whole(b, j), -8));
            assert_eq!(&x - &y, exact(whole(a, i) - whole(b, j), -8));
            assert_eq!(&x * &y, exact(i128::from(a) * i128::from(b), i64::from(i + j)));
            assert_eq!(x.cmp(&y), whole(a, i).cmp(&whole(b, j)));
            assert_eq!(x.abs() == x, a >= 0);
        }
    }

    #[test]
    fn numbers_at_the_ends_of_the_range_are_exact() {
        let least = Dyadic::from(f64::from_bits(1));
        assert_eq!((least.mantissa.clone(), least.exponent), (BigInt::from(1), -1074));
        assert_eq!(&least + &least, Dyadic::from(f64::from_bits(2)));
        let greatest = Dyadic::from(f64::MAX);
        assert_eq!(greatest.exponent, 971);
        assert_eq!(&Dyadic::from(f64::MIN) + &greatest, Dyadic::zero());
        assert!(&greatest + &least > greatest && &greatest - &least < greatest);
        assert_eq!(Dyadic::from(-0.0), Dyadic::zero());
        assert_eq!(Dyadic::from(-0.75f32).abs(), Dyadic::from(0.75));
    }
}
