use restpose_formats::geom::Aabb;

/// A box in two vectors of four lanes, which compilers keep in one register each. The fourth lane means nothing.
///
/// No lane is NaN and no zero is negative, so bounds do not depend on the order in which boxes are met.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LaneBox {
    pub(super) lower: [f32; 4],
    pub(super) upper: [f32; 4],
}

impl LaneBox {
    /// Contains nothing; growing by it changes nothing.
    pub(super) const EMPTY: Self = Self {
        lower: [f32::INFINITY; 4],
        upper: [f32::NEG_INFINITY; 4],
    };

    /// Grows just enough to contain `other`.
    #[inline]
    pub(super) fn grow(&mut self, other: &Self) {
        self.grow_lanes(&other.lower, &other.upper);
    }

    /// Grows just enough to contain `point`.
    #[inline]
    pub(super) fn grow_point(&mut self, point: &[f32; 4]) {
        self.grow_lanes(point, point);
    }

    // `f32::min` must ask for NaN; a comparison is one instruction for four lanes.
    #[inline]
    fn grow_lanes(&mut self, lower: &[f32; 4], upper: &[f32; 4]) {
        for k in 0..4 {
            self.lower[k] = if lower[k] < self.lower[k] {
                lower[k]
            } else {
                self.lower[k]
            };
        }
        for k in 0..4 {
            self.upper[k] = if upper[k] > self.upper[k] {
                upper[k]
            } else {
                self.upper[k]
            };
        }
    }

    /// This box, grown by `other`.
    pub(super) fn union(mut self, other: &Self) -> Self {
        self.grow(other);
        self
    }

    /// [`Aabb::center`] of each axis: does not overflow.
    #[inline]
    pub(super) fn center(&self) -> [f32; 4] {
        std::array::from_fn(|k| 0.5 * self.lower[k] + 0.5 * self.upper[k])
    }

    /// [`Aabb::center`] of one axis.
    #[inline]
    pub(super) fn center_of(&self, axis: usize) -> f32 {
        0.5 * self.lower[axis] + 0.5 * self.upper[axis]
    }

    /// Half its length along one axis: does not overflow.
    #[inline]
    pub(super) fn half_length(&self, axis: usize) -> f32 {
        0.5 * self.upper[axis] - 0.5 * self.lower[axis]
    }

    pub(super) fn to_aabb(self) -> Aabb {
        let three = |[x, y, z, _]: [f32; 4]| [x, y, z];
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
        let four = |[x, y, z]: [f32; 3]| [x + 0.0, y + 0.0, z + 0.0, 0.0];
        Self {
            lower: four(bounds.min),
            upper: four(bounds.max),
        }
    }
}
