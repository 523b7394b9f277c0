use super::{
    ray_bundle::{WideBundle, origin_slack},
    ray_group::{GROUP, RayGroup},
};
use crate::{
    cluster_frame::{EXTENT_LIMIT, SlabLanes},
    set_bits::set_bits,
    simd::Lanes,
    wide::WideNode,
};

/// Bundles of up to eight groups, lane by lane, which one box is tested against.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupBundles {
    /// Least and greatest origins.
    pub(super) origin: [[[f32; GROUP]; 3]; 2],
    /// Least and greatest inverses of directions.
    pub(super) inverse_direction: [[[f32; GROUP]; 3]; 2],
    pub(super) start: [f32; GROUP],
}

impl GroupBundles {
    pub(super) const NONE: Self = Self {
        origin: [[[0.0; GROUP]; 3]; 2],
        inverse_direction: [[[0.0; GROUP]; 3]; 2],
        start: [0.0; GROUP],
    };

    /// The extremes of each group's rays.
    #[inline(always)]
    pub(super) fn set<S: Lanes>(&mut self, simd: S, groups: &[RayGroup; GROUP]) {
        let mut starts = [simd.splat8(0.0); GROUP];
        for group in 0..GROUP {
            starts[group] = simd.load8(&groups[group].range[0]);
        }
        simd.store8(extremes(simd, starts)[0], &mut self.start);
        self.start = self.start.map(f32::next_down);
        let [a, b, c, d, e, f, g, h] = groups;
        let slabs = [
            &a.slabs, &b.slabs, &c.slabs, &d.slabs, &e.slabs, &f.slabs, &g.slabs, &h.slabs,
        ];
        self.set_slabs(simd, slabs);
    }

    /// As [`Self::set`], in another space.
    #[inline(always)]
    pub(super) fn set_slabs<S: Lanes>(&mut self, simd: S, groups: [&SlabLanes; GROUP]) {
        for k in 0..3 {
            let (mut origins, mut inverses) = ([simd.splat8(0.0); GROUP], [simd.splat8(0.0); GROUP]);
            for group in 0..GROUP {
                origins[group] = simd.load8(&groups[group].origin[k]);
                inverses[group] = simd.load8(&groups[group].inverse_direction[k]);
            }
            let (origins, inverses) = (extremes(simd, origins), extremes(simd, inverses));
            for end in 0..2 {
                simd.store8(origins[end], &mut self.origin[end][k]);
                simd.store8(inverses[end], &mut self.inverse_direction[end][k]);
            }
        }
    }
}

impl GroupBundles {
    /// The bundle of some groups together in a cluster's local space, and by how much planes move there, but for margins. Along an
    /// axis along which their rays do not all run the same way, boxes restrict none of them from then on. `None` where numbers
    /// overflow.
    pub(super) fn join(&mut self, groups: u32) -> Option<(WideBundle, [f32; 3])> {
        let mut origin = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        let mut inverse = origin;
        for group in set_bits(groups.into()) {
            let group = group % GROUP;
            for k in 0..3 {
                origin[0][k] = origin[0][k].min(self.origin[0][k][group]);
                origin[1][k] = origin[1][k].max(self.origin[1][k][group]);
                inverse[0][k] = inverse[0][k].min(self.inverse_direction[0][k][group]);
                inverse[1][k] = inverse[1][k].max(self.inverse_direction[1][k][group]);
            }
        }
        let start = set_bits(groups.into()).fold(f32::INFINITY, |start, group| start.min(self.start[group % GROUP]));
        for k in 0..3 {
            if inverse[0][k] <= 0.0 && inverse[1][k] >= 0.0 {
                for end in 0..2 {
                    inverse[end][k] = f32::NAN;
                    self.inverse_direction[end][k] = [f32::NAN; GROUP];
                }
            }
        }
        let outwards = origin_slack(&origin);
        let is_far = |x: &f32| x.abs() > EXTENT_LIMIT as f32;
        if origin.as_flattened().iter().any(is_far) {
            return None;
        }
        Some((WideBundle::from_extremes(&origin, inverse, outwards, start)?, outwards))
    }
}

/// The least and the greatest lane of each.
#[inline(always)]
fn extremes<S: Lanes>(simd: S, of: [S::F8; GROUP]) -> [S::F8; 2] {
    let [a, b, c, d, e, f, g, h] = simd.transpose8(of);
    let least = simd.min8(
        simd.min8(simd.min8(a, b), simd.min8(c, d)),
        simd.min8(simd.min8(e, f), simd.min8(g, h)),
    );
    let greatest = simd.max8(
        simd.max8(simd.max8(a, b), simd.max8(c, d)),
        simd.max8(simd.max8(e, f), simd.max8(g, h)),
    );
    [least, greatest]
}

/// [`GroupBundles`] ready for a tree: a [`WideBundle`] for each group, with the margin of the bundle that they make together,
/// which reaches that of each of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideGroups {
    near: [[f32; GROUP]; 3],
    far: [[f32; GROUP]; 3],
    inverse_direction: [[[f32; GROUP]; 3]; 2],
    near_row: [usize; 3],
    start: [f32; GROUP],
}

impl WideGroups {
    #[inline]
    pub(super) fn new(bundles: &GroupBundles, outwards: [f32; 3], near_row: [usize; 3]) -> Self {
        let mut out = Self {
            near: [[0.0; GROUP]; 3],
            far: [[0.0; GROUP]; 3],
            inverse_direction: bundles.inverse_direction,
            near_row,
            start: bundles.start,
        };
        for k in 0..3 {
            let above: [f32; GROUP] = std::array::from_fn(|group| bundles.origin[1][k][group] + outwards[k]);
            let below: [f32; GROUP] = std::array::from_fn(|group| bundles.origin[0][k][group] - outwards[k]);
            (out.near[k], out.far[k]) = if near_row[k] == 0 {
                (above, below)
            } else {
                (below, above)
            };
        }
        out
    }

    /// A bit for each group of which a ray may be inside a place's box before its limit.
    #[inline(always)]
    pub(super) fn meeting<S: Lanes>(&self, simd: S, node: &WideNode, place: usize, limits: &[f32; GROUP]) -> u32 {
        let place = place % 8;
        let (mut enter, mut exit) = (simd.load8(&self.start), simd.load8(limits));
        for k in 0..3 {
            let near_row = self.near_row[k] & 1;
            let (near, far) = (node.planes[near_row][k][place], node.planes[1 - near_row][k][place]);
            let least = simd.load8(&self.inverse_direction[0][k]);
            let greatest = simd.load8(&self.inverse_direction[1][k]);
            let near = simd.sub8(simd.splat8(near), simd.load8(&self.near[k]));
            let far = simd.sub8(simd.splat8(far), simd.load8(&self.far[k]));
            let near = simd.min8(simd.mul8(near, least), simd.mul8(near, greatest));
            let far = simd.max8(simd.mul8(far, least), simd.mul8(far, greatest));
            enter = simd.max8(near, enter);
            exit = simd.min8(far, exit);
        }
        simd.le8(enter, exit)
    }

    /// The bundle of one group.
    #[inline(always)]
    pub(super) fn one(&self, group: usize) -> WideBundle {
        let group = group % GROUP;
        WideBundle {
            near: std::array::from_fn(|k| self.near[k][group]),
            far: std::array::from_fn(|k| self.far[k][group]),
            inverse_direction: [0, 1].map(|end: usize| std::array::from_fn(|k| self.inverse_direction[end][k][group])),
            near_row: self.near_row,
            start: self.start[group],
        }
    }
}
