use super::lane_box::LaneBox;
use super::measure::Measure;
use super::primitive::{Extent, Primitive};

/// Bins per node, K. Source: Wald 2007, §3.7.
pub(super) const BINS: usize = 16;

/// Tells the bin of a primitive by its centroid along one axis.
///
/// Guarantee: bins ascend with centroids, the least centroid is in the first bin and the greatest in the last. So no
/// split between two bins leaves a side empty.
///
/// Source: Wald 2007, §3.3: binID = k₁ (c − k₀) with k₁ = K (1 − ε) / (greatest − least), k₀ = least. In `f64`, where
/// nothing over- or underflows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    axis: usize,
    least: f64,
    factor: f64,
}

/// 1 − ε. The division, the difference and the product err by 2⁻⁵³ each, which 2⁻⁵⁰ outweighs: the greatest centroid stays
/// below K, and above K − 1.
const BELOW_ONE: f64 = 1.0 - 1.0 / (1_u64 << 50) as f64;

impl Projection {
    /// Along the axis on which centroids lie farthest apart; `None` when all coincide.
    pub(super) fn new(extent: &Extent) -> Option<Self> {
        let axis = extent.widest_centroid_axis()?;
        let [least, greatest] = extent.centroids.sides(axis).map(f64::from);
        Some(Self {
            axis,
            least,
            factor: BINS as f64 * BELOW_ONE / (greatest - least),
        })
    }

    pub(super) fn axis(&self) -> usize {
        self.axis
    }

    /// Below [`BINS`] for each primitive in the extent.
    #[inline]
    pub(super) fn bin(&self, primitive: &Primitive) -> usize {
        let centroid = f64::from(primitive.bounds().center_of(self.axis));
        ((centroid - self.least) * self.factor) as u8 as usize
    }
}

/// What fell into each bin: Wald 2007, §3.4.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    counts: [u32; BINS],
    bounds: [LaneBox; BINS],
}

/// Between which bins a node is parted.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinSplit {
    /// The first bin on the right.
    pub(super) bin: usize,
    /// n_l SA(N_l) + n_r SA(N_r), in the node's measure.
    pub(super) parts: f32,
}

impl Bins {
    pub(super) const EMPTY: Self = Self {
        counts: [0; BINS],
        bounds: [LaneBox::EMPTY; BINS],
    };

    pub(super) fn fill(&mut self, primitives: &[Primitive], projection: &Projection) {
        *self = Self::EMPTY;
        for primitive in primitives {
            let bin = projection.bin(primitive);
            self.counts[bin] += 1;
            self.bounds[bin].grow(primitive.bounds());
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for bin in 0..BINS {
            self.counts[bin] += other.counts[bin];
            self.bounds[bin].grow(&other.bounds[bin]);
        }
    }

    /// Primitives in the bins before `bin`.
    pub(super) fn count_before(&self, bin: usize) -> u32 {
        self.counts[..bin].iter().sum()
    }

    /// The cheapest split by Eq. 4.3, the lowest of equal ones: Wald 2007, §3.5. Two bins at least must be occupied.
    ///
    /// Only occupied bins are looked at: the splits on either side of an empty one are the same, and small nodes leave
    /// most of them empty.
    pub(super) fn cheapest_split(&self, measure: &Measure) -> BinSplit {
        let mut occupied = 0_u32;
        for bin in 0..BINS {
            occupied |= u32::from(self.counts[bin] != 0) << bin;
        }
        // Left of each occupied bin but the first: n_l SA(N_l) and n_l.
        let mut left = [(0.0, 0); BINS];
        let mut bounds = LaneBox::EMPTY;
        let mut count = 0;
        let mut rest = occupied;
        while rest != 0 {
            let bin = rest.trailing_zeros() as usize & (BINS - 1);
            rest &= rest - 1;
            left[bin] = (measure.of(&bounds) * count as f32, count);
            bounds.grow(&self.bounds[bin]);
            count += self.counts[bin];
        }
        let mut best = BinSplit {
            bin: 0,
            parts: f32::INFINITY,
        };
        bounds = LaneBox::EMPTY;
        rest = occupied & occupied.wrapping_sub(1);
        while rest != 0 {
            let bin = (31 - rest.leading_zeros()) as usize & (BINS - 1);
            rest ^= 1 << bin;
            bounds.grow(&self.bounds[bin]);
            let (left_part, left_count) = left[bin];
            let parts = left_part + measure.of(&bounds) * (count - left_count) as f32;
            if parts <= best.parts {
                best = BinSplit { bin, parts };
            }
        }
        best
    }
}
