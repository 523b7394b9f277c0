use super::bvh_primitive::BoxLanes;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::simd::{Lanes, Portable, SimdLevel};

/// The box around primitives, and the longest side that one of them has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub bounds: BoxLanes,
    /// Infinite where it is too long for a number.
    pub longest: f32,
}

impl Extent {
    /// Of no primitives.
    pub(super) const NONE: Self = Self {
        bounds: BoxLanes::EMPTY,
        longest: 0.0,
    };

    /// Of both.
    pub(super) fn join(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(&other.bounds),
            longest: self.longest.max(other.longest),
        }
    }

    /// Whether all primitives are far shorter than the box around them. No where sides are too long for a number.
    pub(super) fn is_even(&self) -> bool {
        let [x, y, z] = [0, 1, 2].map(|axis| self.bounds.0[4 + axis] + self.bounds.0[axis]);
        let longest = x.max(y).max(z);
        longest < f32::INFINITY && self.longest < longest / 16.0
    }

    /// Of a list.
    pub(super) fn of(level: SimdLevel, primitives: &[BoxLanes]) -> Self {
        #[inline(always)]
        fn body<S: Lanes>(simd: S, primitives: &[BoxLanes]) -> Extent {
            let mut union = simd.load8(&BoxLanes::EMPTY.0);
            let mut longest = simd.splat4(0.0);
            for primitive in primitives {
                let own = simd.load8(&primitive.0);
                union = simd.max8(union, own);
                let [negated_min, max] = simd.halves(own);
                longest = simd.max4(longest, simd.add4(max, negated_min));
            }
            let mut bounds = BoxLanes::EMPTY;
            simd.store8(union, &mut bounds.0);
            let [x, y, z, _] = simd.store4(longest);
            let longest = x.max(y).max(z);
            Extent { bounds, longest }
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, primitives: &[BoxLanes]) -> Extent {
                body(simd, primitives)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, primitives) };
        }
        body(Portable, primitives)
    }
}
