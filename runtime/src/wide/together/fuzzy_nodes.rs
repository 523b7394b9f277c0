use super::{local_lattice::LocalLattice, walk::BundleTree};
use crate::{
    simd::{Lanes, prefetch},
    wide::{
        WideNode,
        fuzzy_ray::{FuzzyBoxes, follows},
    },
};
use restpose_formats::rows::{MAX_WIDE_DEPTH, WideNodeRow};

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

impl<'a> FuzzyNodes<'a> {
    /// The lattices are those of the fuzzy boxes, and of the rest positions.
    pub(crate) fn new(
        rows: &'a [WideNodeRow],
        boxes: FuzzyBoxes<'a>,
        lattices: [LocalLattice; 2],
        path: &'a mut FuzzyPath,
    ) -> Self {
        Self {
            rows,
            boxes,
            lattices,
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
            let [least, greatest] = lattice.widened(simd, k, planes[k]);
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
