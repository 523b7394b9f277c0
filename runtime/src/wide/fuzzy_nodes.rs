use super::{
    fuzzy_ray::{FuzzyBoxes, follows},
    node::WideNode,
    packet_walk::BundleTree,
};
use crate::{
    cluster_frame::BundleFrame,
    simd::{Lanes, prefetch},
};
use restpose_formats::{
    geom::round::UNIT_ROUNDOFF,
    rows::{MAX_WIDE_DEPTH, RestLattice, WideNodeRow},
};

/// Nodes of a cluster's tree on the way down to where a bundle is.
pub(crate) type FuzzyPath = [WideNode; MAX_WIDE_DEPTH];

/// A cluster's wide tree as a bundle goes down it: boxes of nodes in local space, widened by the margin, made once for all rays when
/// they first meet the node.
pub(crate) struct FuzzyNodes<'a> {
    rows: &'a [WideNodeRow],
    boxes: FuzzyBoxes<'a>,
    /// Of the fuzzy boxes, and of the rest positions.
    lattices: [LocalLattice; 2],
    path: &'a mut FuzzyPath,
}

/// A lattice, as its planes are taken to local space.
#[derive(Clone, Copy)]
struct LocalLattice {
    zero: [f32; 3],
    step: [f32; 3],
    margin: [f32; 3],
}

impl LocalLattice {
    /// Widened so that a plane need not be exact: `fl(zero + fl(step·q))` is off by u relative to itself, and so to the sum of both
    /// magnitudes, and by u relative to the product. What is relative to the product is in the margin, where more roundings of it
    /// are counted than there are (`cluster_frame`); four units of the other are more than all roundings of it.
    fn new(zero: [f32; 3], step: [f32; 3], margin: [f32; 3]) -> Self {
        let widened = |k: usize| margin[k] + (4.0 * UNIT_ROUNDOFF) as f32 * zero[k].abs();
        Self {
            zero,
            step,
            margin: std::array::from_fn(widened),
        }
    }
}

impl<'a> FuzzyNodes<'a> {
    /// `zero` and `step` are those of the lattice of the fuzzy boxes.
    pub(crate) fn new(
        rows: &'a [WideNodeRow],
        boxes: FuzzyBoxes<'a>,
        (zero, step): ([f32; 3], [f32; 3]),
        rest: &RestLattice,
        frame: &BundleFrame,
        path: &'a mut FuzzyPath,
    ) -> Self {
        Self {
            rows,
            boxes,
            lattices: [
                LocalLattice::new(zero, step, frame.margin),
                LocalLattice::new(rest.origin, [rest.step; 3], frame.margin_posed),
            ],
            path,
        }
    }
}

impl BundleTree for FuzzyNodes<'_> {
    #[inline(always)]
    fn enter<S: Lanes>(&mut self, simd: S, child: u32, above: Option<u32>) -> u32 {
        let depth = match above {
            Some(above) => above as usize + 1,
            None => 0,
        };
        let row = &self.rows[child as usize];
        let planes = self.boxes.planes(simd, row, child);
        let lattice = &self.lattices[usize::from(follows(row))];
        let node = &mut self.path[depth % MAX_WIDE_DEPTH];
        node.children = row.children;
        for k in 0..3 {
            let (zero, step) = (simd.splat8(lattice.zero[k]), simd.splat8(lattice.step[k]));
            let margin = simd.splat8(lattice.margin[k]);
            let [least, greatest] = planes[k];
            let least = simd.sub8(simd.add8(zero, simd.mul8(least, step)), margin);
            let greatest = simd.add8(simd.add8(zero, simd.mul8(greatest, step)), margin);
            simd.store8(least, &mut node.planes[0][k]);
            simd.store8(greatest, &mut node.planes[1][k]);
        }
        depth as u32
    }

    #[inline(always)]
    fn node(&self, at: u32) -> &WideNode {
        &self.path[at as usize % MAX_WIDE_DEPTH]
    }

    #[inline(always)]
    fn prefetch(&self, child: u32) {
        prefetch(std::slice::from_ref(&self.rows[child as usize]));
        self.boxes.prefetch(child);
    }
}
