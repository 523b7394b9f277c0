use super::lane_box::LaneBox;
use super::measure::Measure;
use super::primitive::{Extent, Primitive};
use restpose_runtime::build::BinCount;
use wide::f32x4;

/// What fell into one bin along one axis.
///
/// The lower side of the centroids' box across that axis is the smallest centroid, by which nodes are parted. The rest of
/// it is for the children: their bins lie over their centroids' intervals, which must be known before the pass that
/// fills them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bin {
    extent: Extent,
    count: u32,
}

impl Bin {
    pub(super) const EMPTY: Self = Self {
        extent: Extent::EMPTY,
        count: 0,
    };
}

/// Maps centroids to bins that are uniform over their interval, on all axes at once.
///
/// Guarantee: bins ascend with centroids, whatever is rounded, and the least centroid is in the first. Where the interval
/// is so short that its inverse overflows, few bins are used; what lies farther from the least centroid than the
/// largest number is in the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMap {
    least: f32x4,
    factor: f32x4,
    last: f32x4,
    count: usize,
}

impl BinMap {
    /// With `count` bins along each axis; `None` when all centroids coincide.
    pub(super) fn new(extent: &Extent, count: usize) -> Option<Self> {
        extent.widest_centroid_axis()?;
        // The fourth lane is no axis: its factor is zero.
        let factor = [0, 1, 2, 3].map(|axis| match axis {
            3 => 0.0,
            _ => (count as f64 / extent.centroids.length(axis)).min(f64::from(f32::MAX)) as f32,
        });
        Some(Self {
            least: extent.centroids.lower,
            factor: f32x4::new(factor),
            last: f32x4::splat((count - 1) as f32),
            count,
        })
    }

    /// Bins along all axes together.
    pub(super) fn len(&self) -> usize {
        3 * self.count
    }

    /// Adds a primitive to its bin along each axis; `bins` are [`len`](Self::len), by axis.
    #[inline]
    pub(super) fn add(&self, primitive: &Primitive, bins: &mut [Bin]) {
        let center = primitive.bounds().center();
        let places = ((center - self.least) * self.factor)
            .fast_min(self.last)
            .fast_trunc_int();
        for axis in 0..3 {
            let bin = &mut bins[axis * self.count + places.as_array()[axis] as usize];
            bin.extent.bounds.grow(primitive.bounds());
            bin.extent.centroids.grow_point(center);
            bin.count += 1;
        }
    }
}

/// Where a node is parted: at the lower border of a bin that is not empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    pub(super) axis: usize,
    bin: usize,
    /// n_l SA(N_l) + n_r SA(N_r), in the node's measure.
    pub(super) parts: f32,
}

/// Primitives on one side of a border.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) extent: Extent,
    pub(super) count: usize,
}

impl Border {
    /// The cheapest by Eq. 4.3, of equal ones the lowest axis, then the lowest bin; `None` when no axis has two bins that
    /// are not empty.
    pub(super) fn cheapest(bins: &[Bin], map: &BinMap, measure: &Measure) -> Option<Self> {
        let mut best: Option<Self> = None;
        for (axis, bins) in bins.chunks_exact(map.count).enumerate() {
            let mut below = [0.0; BinCount::LIMIT as usize];
            let (mut bounds, mut count) = (LaneBox::EMPTY, 0);
            for (bin, below) in bins.iter().zip(&mut below) {
                if bin.count != 0 {
                    *below = measure.of(&bounds) * count as f32;
                    bounds.grow(&bin.extent.bounds);
                    count += bin.count;
                }
            }
            (bounds, count) = (LaneBox::EMPTY, 0);
            let mut on_axis: Option<Self> = None;
            for (place, bin) in bins.iter().enumerate().skip(1).rev() {
                if bin.count != 0 {
                    bounds.grow(&bin.extent.bounds);
                    count += bin.count;
                    let parts = below[place] + measure.of(&bounds) * count as f32;
                    if on_axis.is_none_or(|best| parts <= best.parts) {
                        on_axis = Some(Self {
                            axis,
                            bin: place,
                            parts,
                        });
                    }
                }
            }
            if on_axis.is_some_and(|found| best.is_none_or(|best| found.parts < best.parts)) {
                best = on_axis;
            }
        }
        best
    }

    /// The smallest centroid in the bin above: those of the left child are less, those of the right one are not.
    pub(super) fn plane(&self, bins: &[Bin], map: &BinMap) -> f32 {
        let [least, _] = bins[self.axis * map.count + self.bin].extent.centroids.sides(self.axis);
        least
    }

    pub(super) fn sides(&self, bins: &[Bin], map: &BinMap) -> [Side; 2] {
        let bins = &bins[self.axis * map.count..][..map.count];
        let (lower, upper) = bins.split_at(self.bin);
        [lower, upper].map(|bins| {
            let mut side = Bin::EMPTY;
            for bin in bins {
                side.extent = side.extent.union(&bin.extent);
                side.count += bin.count;
            }
            Side {
                extent: side.extent,
                count: side.count as usize,
            }
        })
    }
}
