use crate::simd::{Lanes, Portable};
use restpose_formats::geom::Aabb;

/// Keeps lanes that hold integers away from subnormal numbers, on which arithmetic takes a hundred times as long.
const INTEGER_MASK: u32 = 1 << 30;

/// A box and what it is of, in one AVX register or two of SSE.
///
/// ```text
/// lane   0      1      2      3    4      5      6      7
///       −min.x −min.y −min.z  id   max.x  max.y  max.z  count
/// ```
///
/// With the lower side negated a union is one lane-wise maximum. Of unions lane 3 means nothing, and lane 7 only in bins,
/// which count there.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxLanes(pub [f32; 8]);

impl BoxLanes {
    /// The neutral element of [`BoxLanes::union`].
    pub(super) const EMPTY: Self = {
        let mut lanes = [f32::NEG_INFINITY; 8];
        lanes[7] = f32::from_bits(INTEGER_MASK);
        Self(lanes)
    };

    #[inline(always)]
    pub(super) fn new(bounds: &Aabb, id: u32) -> Self {
        let Aabb { min: a, max: b } = bounds;
        Self([
            -a[0],
            -a[1],
            -a[2],
            f32::from_bits(id ^ INTEGER_MASK),
            b[0],
            b[1],
            b[2],
            0.0,
        ])
    }

    #[inline(always)]
    pub(super) fn id(&self) -> u32 {
        self.0[3].to_bits() ^ INTEGER_MASK
    }

    /// How many boxes were counted into this union, which began as [`BoxLanes::EMPTY`]: in the bits of lane 7.
    #[inline(always)]
    pub(super) fn count(&self) -> u32 {
        self.0[7].to_bits().wrapping_sub(INTEGER_MASK)
    }

    #[inline(always)]
    pub(super) fn aabb(&self) -> Aabb {
        let lanes = &self.0;
        Aabb {
            min: [-lanes[0], -lanes[1], -lanes[2]],
            max: [lanes[4], lanes[5], lanes[6]],
        }
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        let mut out = Self::EMPTY;
        Portable.store8(Portable.max8(self.0, other.0), &mut out.0);
        out
    }

    /// Half of the box's center, per axis, and a lane that means nothing: halved, so that the distance of any two is
    /// finite. Ascends with both sides of the box.
    #[inline(always)]
    pub(super) fn half_center<S: Lanes>(&self, simd: S) -> S::F4 {
        let quarter = simd.splat4(0.25);
        let [negated_min, max] = simd.halves(simd.load8(&self.0));
        simd.sub4(simd.mul4(max, quarter), simd.mul4(negated_min, quarter))
    }
}

impl BoxLanes {
    /// [`BoxLanes::half_center`] along one axis.
    #[inline(always)]
    pub(super) fn half_center_along(&self, axis: usize) -> f32 {
        0.25 * self.0[4 + axis] - 0.25 * self.0[axis]
    }
}

/// Half of the surface area of a box, in units in which `scale` makes lengths near one.
#[inline(always)]
pub(super) fn half_area<S: Lanes>(simd: S, bounds: S::F8, scale: S::F4) -> f32 {
    let [negated_min, max] = simd.halves(bounds);
    // Scaled first: the sides of finite boxes may overflow.
    simd.pair_products(simd.add4(simd.mul4(max, scale), simd.mul4(negated_min, scale)))
}

/// The box around all of `list`.
#[inline(always)]
pub(super) fn around<S: Lanes>(simd: S, list: &[BoxLanes]) -> BoxLanes {
    let mut union = simd.load8(&BoxLanes::EMPTY.0);
    for other in list {
        union = simd.max8(union, simd.load8(&other.0));
    }
    let mut out = BoxLanes::EMPTY;
    simd.store8(union, &mut out.0);
    out
}
