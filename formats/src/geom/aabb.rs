use bytemuck::{Pod, Zeroable};

/// An axis-aligned box, closed on both sides. Empty when `min > max` on any axis.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Aabb {
    /// Least corner.
    pub min: [f32; 3],
    /// Greatest corner.
    pub max: [f32; 3],
}

impl Aabb {
    /// The box that contains nothing; the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    /// The box that contains everything.
    pub const EVERYTHING: Self = Self {
        min: [f32::NEG_INFINITY; 3],
        max: [f32::INFINITY; 3],
    };

    /// The smallest box around `points`; [`Aabb::EMPTY`] for none.
    #[inline]
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }

    /// This box, grown just enough to contain `point`.
    #[inline]
    #[must_use]
    pub fn with_point(self, point: [f32; 3]) -> Self {
        self.union(Self { min: point, max: point })
    }

    /// The smallest box around both.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let mut out = self;
        for k in 0..3 {
            out.min[k] = out.min[k].min(other.min[k]);
            out.max[k] = out.max[k].max(other.max[k]);
        }
        out
    }

    /// True when it contains no point.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    /// True when both boxes share a point; touching counts.
    #[inline]
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// True when `point` lies inside or on the surface.
    #[inline]
    #[must_use]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        (0..3).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// True when the whole of `other` lies inside; an empty box lies inside every box.
    #[inline]
    #[must_use]
    pub fn contains_box(&self, other: &Self) -> bool {
        other.is_empty() || (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// Surface area in `f64`: no overflow for any finite box. Zero when empty.
    #[inline]
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let [x, y, z] = std::array::from_fn(|k| f64::from(self.max[k]) - f64::from(self.min[k]));
        2.0 * (x * y + y * z + z * x)
    }

    /// Midpoint, rounded to nearest. Does not overflow.
    #[inline]
    #[must_use]
    pub fn center(&self) -> [f32; 3] {
        std::array::from_fn(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }
}
