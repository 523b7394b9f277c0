use super::lane_box::LaneBox;
use restpose_formats::geom::Aabb;

/// A box and its index in 32 bytes.
///
/// The index is in the fourth lanes, 16 bits in each, as the low bits of numbers between 1 and 2: arithmetic on all four
/// lanes then meets neither NaN nor numbers so small that processors slow down.
///
/// ```text
/// lower[3]: [31..16] 0x3f80   [15..0] bits 31 to 16 of the index
/// upper[3]: [31..16] 0x3f80   [15..0] bits 15 to 0
/// ```
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Primitive(LaneBox);

const ONE: u32 = 0x3f80_0000;

impl Primitive {
    #[inline]
    pub(super) fn new(bounds: &Aabb, id: u32) -> Self {
        let mut lanes = LaneBox::from(bounds);
        lanes.lower.as_mut_array()[3] = f32::from_bits(ONE | id >> 16);
        lanes.upper.as_mut_array()[3] = f32::from_bits(ONE | id & 0xffff);
        Self(lanes)
    }

    #[inline]
    pub(super) fn bounds(&self) -> &LaneBox {
        &self.0
    }

    #[inline]
    pub(super) fn id(&self) -> u32 {
        let [high, low] = self.0.sides(3);
        high.to_bits() << 16 | low.to_bits() & 0xffff
    }
}

/// The box around some primitives, and that around their centroids.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: LaneBox,
    pub(super) centroids: LaneBox,
}

impl Extent {
    pub(super) const EMPTY: Self = Self {
        bounds: LaneBox::EMPTY,
        centroids: LaneBox::EMPTY,
    };

    pub(super) fn of(primitives: &[Primitive]) -> Self {
        let mut extent = Self::EMPTY;
        for primitive in primitives {
            extent.grow(primitive);
        }
        extent
    }

    #[inline]
    pub(super) fn grow(&mut self, primitive: &Primitive) {
        self.bounds.grow(primitive.bounds());
        self.centroids.grow_point(primitive.bounds().center());
    }

    pub(super) fn union(self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(&other.bounds),
            centroids: self.centroids.union(&other.centroids),
        }
    }

    /// The axis along which centroids lie farthest apart, the lowest of equal ones; `None` when all coincide.
    pub(super) fn widest_centroid_axis(&self) -> Option<usize> {
        let axis = self.centroids.longest_axis();
        (self.centroids.length(axis) > 0.0).then_some(axis)
    }
}

/// Lists `boxes`, whose indices begin at `first`, and returns their extent.
pub(super) fn list_boxes(boxes: &[Aabb], first: usize, list: &mut [Primitive]) -> Extent {
    let mut extent = Extent::EMPTY;
    for (index, (bounds, primitive)) in boxes.iter().zip(list).enumerate() {
        *primitive = Primitive::new(bounds, (first + index) as u32);
        extent.grow(primitive);
    }
    extent
}

/// Makes `list` just `len` long, for all to be overwritten.
pub(super) fn set_len<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    // A list that moves is made anew: nothing of the old one is worth a copy.
    if list.capacity() < len {
        list.clear();
    }
    list.resize(len, value);
}

/// Writes the indices of `primitives` ascending.
pub(super) fn write_references(primitives: &[Primitive], references: &mut [u32]) {
    for (reference, primitive) in references.iter_mut().zip(primitives) {
        *reference = primitive.id();
    }
    references.sort_unstable();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_boxes_come_back() {
        let bounds = Aabb {
            min: [-1.0, 2.0, f32::MIN],
            max: [1.0, 2.0, f32::MAX],
        };
        for id in [0, 1, 0xffff, 0x1_0000, 0x1234_5678, 0x7fff_ffff, u32::MAX] {
            let primitive = Primitive::new(&bounds, id);
            assert_eq!((primitive.id(), primitive.bounds().to_aabb()), (id, bounds));
            let lanes = primitive.bounds().sides(3);
            assert!(lanes.iter().all(|x| (1.0..2.0).contains(x)), "{lanes:?}");
        }
        assert_eq!(size_of::<Primitive>(), 32);
    }

    #[test]
    fn the_widest_axis_is_found_beyond_the_largest_number() {
        let point = |p: [f32; 3]| Primitive::new(&Aabb { min: p, max: p }, 0);
        let axis = |points: [[f32; 3]; 2]| Extent::of(&points.map(point)).widest_centroid_axis();
        assert_eq!(axis([[f32::MIN, f32::MIN, 0.0], [1e38, f32::MAX, 0.0]]), Some(1));
        assert_eq!(axis([[3.0, 0.0, 0.0], [3.0, 4e-45, 0.0]]), Some(1));
        assert_eq!(axis([[3.0, 2.0, -0.0], [3.0, 2.0, 0.0]]), None);
    }
}
