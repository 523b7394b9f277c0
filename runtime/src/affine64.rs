use crate::simd::{Doubles, Four, Lanes, weighted_sum};
use restpose_formats::geom::Affine;

/// An affine map in `f64`, by columns. Rows of four would need no number that means nothing, but their last one, which takes
/// the translation, keeps the compiler from vectors (measured on the fox: 1.42 instead of 1.38 µs per pose).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine64 {
    /// Three numbers and one that means nothing.
    pub columns: [Four; 4],
}

impl Affine64 {
    pub(crate) const IDENTITY: Self = Self {
        columns: [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0; 4],
        ],
    };

    /// Looks at the translation first, where most maps differ.
    #[inline(always)]
    pub(crate) fn is_identity(&self) -> bool {
        let ([a, b, c, d], [x, y, z, origin]) = (&self.columns, &Self::IDENTITY.columns);
        d == origin && a == x && b == y && c == z
    }

    /// Of the images of the three axes and the translation.
    #[inline(always)]
    pub(crate) fn new([a, b, c, d]: &[[f64; 3]; 4]) -> Self {
        let column = |[x, y, z]: &[f64; 3]| [*x, *y, *z, 0.0];
        Self {
            columns: [column(a), column(b), column(c), column(d)],
        }
    }

    #[inline(always)]
    pub(crate) fn from_affine(map: &Affine) -> Self {
        let [a, b, c, d] = &map.columns;
        let column = |[x, y, z]: &[f32; 3]| [f64::from(*x), f64::from(*y), f64::from(*z), 0.0];
        Self {
            columns: [column(a), column(b), column(c), column(d)],
        }
    }

    pub(crate) fn numbers(&self) -> [[f64; 3]; 4] {
        self.columns.map(|[x, y, z, _]| [x, y, z])
    }

    /// `self` after `inner`.
    #[inline(always)]
    pub(crate) fn after<S: Lanes>(&self, simd: S, inner: &Self) -> Self {
        let [a, b, c, d] = &self.columns;
        let linear = [Doubles::new(simd, a), Doubles::new(simd, b), Doubles::new(simd, c)];
        let d = Doubles::new(simd, d);
        let [[x0, x1, x2, _], [y0, y1, y2, _], [z0, z1, z2, _], [t0, t1, t2, _]] = inner.columns;
        Self {
            columns: [
                weighted_sum(linear, [x0, x1, x2]).numbers(),
                weighted_sum(linear, [y0, y1, y2]).numbers(),
                weighted_sum(linear, [z0, z1, z2]).numbers(),
                (weighted_sum(linear, [t0, t1, t2]) + d).numbers(),
            ],
        }
    }

    /// [`Self::after`] a stored map, each entry rounded.
    #[inline(always)]
    pub(crate) fn rounded_after<S: Lanes>(&self, simd: S, inner: &Affine) -> Affine {
        let [a, b, c, d] = &self.columns;
        let linear = [Doubles::new(simd, a), Doubles::new(simd, b), Doubles::new(simd, c)];
        let d = Doubles::new(simd, d);
        let [x, y, z, offset] = inner.columns;
        Affine {
            columns: [
                weighted_sum(linear, wide(x)).to_point(),
                weighted_sum(linear, wide(y)).to_point(),
                weighted_sum(linear, wide(z)).to_point(),
                (weighted_sum(linear, wide(offset)) + d).to_point(),
            ],
        }
    }
}

/// As `map`, which compilers leave a call.
#[inline(always)]
pub(crate) fn wide([x, y, z]: [f32; 3]) -> [f64; 3] {
    [f64::from(x), f64::from(y), f64::from(z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_entry_makes_another_map() {
        assert!(Affine64::from_affine(&Affine::IDENTITY).is_identity());
        for entry in 0..12 {
            let mut map = Affine::IDENTITY;
            map.columns[entry / 3][entry % 3] += 0.5;
            assert!(!Affine64::from_affine(&map).is_identity(), "{entry}");
        }
    }
}
