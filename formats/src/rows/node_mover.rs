use super::{ClusterBoneRow, WideNodeRow};
use crate::geom::{Aabb, round::f32_above};
use bytemuck::{Pod, Zeroable};

/// Bones beside the cluster's own that boxes of its nodes can follow: the first so many of its cluster-bone rows.
pub const MAX_MOVERS: usize = 8;

/// One over the least weight that a [`NodeMoverRow`] tells from none.
pub const MOVER_WEIGHTS: f32 = 65536.0;

/// By which weights a bone moves what is in the eight boxes of a [`WideNodeRow`].
///
/// A vertex below a place has a weight within `spread` of `weight`, both in parts of [`MOVER_WEIGHTS`], in exact
/// arithmetic; one that the bone does not move has the weight zero. Bones for which a node has no row move nothing below it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct NodeMoverRow {
    /// Per place.
    pub weight: [u16; 8],
    /// Per place.
    pub spread: [u16; 8],
    /// The bone, counted among the cluster's cluster-bone rows but for its own bone's; below [`MAX_MOVERS`].
    pub mover: u32,
}

/// The lattice of the boxes of nodes with movers: `origin + q·step` in exact arithmetic, the same step for all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestLattice {
    /// Least corner of the rest positions of the cluster's vertices, local space.
    pub origin: [f32; 3],
    /// Not a positive normal number where there is no lattice.
    pub step: f32,
}

impl RestLattice {
    /// That of a cluster with these cluster-bone rows.
    #[must_use]
    pub fn new(cluster_bones: &[ClusterBoneRow]) -> Self {
        let bounds = cluster_bones
            .iter()
            .fold(Aabb::EMPTY, |bounds, row| bounds.union(row.bounds));
        let sides = (0..3).map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]));
        let side = sides.fold(0.0, f64::max);
        Self {
            origin: bounds.min,
            // Two steps to spare, for what rounding adds to places.
            step: f32_above(side / f64::from(u16::MAX - 2)),
        }
    }

    /// Whether there is a lattice.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        self.step.is_normal() && self.step > 0.0 && self.origin.iter().all(|x| x.is_finite())
    }

    /// Least and greatest corner of the smallest box on the lattice that contains one in rest space, and one step more on
    /// each side where rounding might matter. The box lies inside of the rest positions' box.
    #[must_use]
    pub fn around(&self, rest: &Aabb) -> [[u16; 3]; 2] {
        // Relative to the width of the lattice, by which two roundings in `f64` are off.
        let slack = f64::from(u16::MAX) / (1u64 << 40) as f64;
        let place = |x: f32, k: usize| (f64::from(x) - f64::from(self.origin[k])) / f64::from(self.step);
        // The casts saturate.
        [
            std::array::from_fn(|k| (place(rest.min[k], k) - slack).floor() as u16),
            std::array::from_fn(|k| (place(rest.max[k], k) + slack).ceil() as u16),
        ]
    }
}

impl WideNodeRow {
    /// Its movers among those of a file.
    #[inline]
    #[must_use]
    pub fn movers<'a>(&self, all: &'a [NodeMoverRow]) -> &'a [NodeMoverRow] {
        &all[self.mover_first as usize..][..self.mover_count as usize]
    }
}
