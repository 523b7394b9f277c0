use restpose_formats::geom::Aabb;
use wide::f32x4;

/// A box in two vectors of four lanes. The fourth lane means nothing.
///
/// No lane is NaN and no zero is negative, so bounds do not depend on the order in which boxes are met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LaneBox {
    pub(super) lower: f32x4,
    pub(super) upper: f32x4,
}

impl LaneBox {
    /// Contains nothing; growing by it changes nothing.
    pub(super) const EMPTY: Self = Self {
        lower: f32x4::new([f32::INFINITY; 4]),
        upper: f32x4::new([f32::NEG_INFINITY; 4]),
    };

    /// Grows just enough to contain `other`.
    #[inline]
    pub(super) fn grow(&mut self, other: &Self) {
        self.lower = self.lower.fast_min(other.lower);
        self.upper = self.upper.fast_max(other.upper);
    }

    /// Grows just enough to contain `point`.
    #[inline]
    pub(super) fn grow_point(&mut self, point: f32x4) {
        self.lower = self.lower.fast_min(point);
        self.upper = self.upper.fast_max(point);
    }

    /// This box, grown by `other`.
    pub(super) fn union(mut self, other: &Self) -> Self {
        self.grow(other);
        self
    }

    /// The lower and the upper side across one axis.
    #[inline]
    pub(super) fn sides(&self, axis: usize) -> [f32; 2] {
        [self.lower.as_array()[axis], self.upper.as_array()[axis]]
    }

    /// [`Aabb::center`] of each axis: does not overflow.
    #[inline]
    pub(super) fn center(&self) -> f32x4 {
        let half = f32x4::splat(0.5);
        half * self.lower + half * self.upper
    }

    /// [`Aabb::center`] of one axis.
    #[inline]
    pub(super) fn center_of(&self, axis: usize) -> f32 {
        let [lower, upper] = self.sides(axis);
        0.5 * lower + 0.5 * upper
    }

    /// Its length along one axis: neither over- nor underflows.
    #[inline]
    pub(super) fn length(&self, axis: usize) -> f64 {
        let [lower, upper] = self.sides(axis).map(f64::from);
        upper - lower
    }

    /// The axis along which it is longest, the lowest of equal ones.
    #[inline]
    pub(super) fn longest_axis(&self) -> usize {
        let mut longest = 0;
        for axis in 1..3 {
            if self.length(axis) > self.length(longest) {
                longest = axis;
            }
        }
        longest
    }

    #[inline]
    pub(super) fn to_aabb(self) -> Aabb {
        let three = |lanes: f32x4| {
            let [x, y, z, _] = lanes.to_array();
            [x, y, z]
        };
        Aabb {
            min: three(self.lower),
            max: three(self.upper),
        }
    }
}

impl From<&Aabb> for LaneBox {
    #[inline]
    fn from(bounds: &Aabb) -> Self {
        // Adding zero turns −0 into +0.
        let four = |[x, y, z]: [f32; 3]| f32x4::new([x, y, z, 0.0]) + f32x4::splat(0.0);
        Self {
            lower: four(bounds.min),
            upper: four(bounds.max),
        }
    }
}
