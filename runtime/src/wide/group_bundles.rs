use super::{
    WideNode,
    bundle::WideBundle,
    ray_group::{GROUP, RayGroup},
};
use crate::simd::Lanes;

/// Bundles of up to eight groups, lane by lane, which one box is tested against.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupBundles {
    /// Least and greatest origins.
    origin: [[[f32; GROUP]; 3]; 2],
    /// Least and greatest inverses of directions.
    inverse_direction: [[[f32; GROUP]; 3]; 2],
    start: [f32; GROUP],
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
        for row in 0..7 {
            let mut lanes = [simd.splat8(0.0); GROUP];
            for group in 0..GROUP {
                let RayGroup {
                    rows,
                    inverse_direction,
                    ..
                } = &groups[group];
                lanes[group] = simd.load8(match row {
                    3..6 => &inverse_direction[row - 3],
                    _ => &rows[row],
                });
            }
            let [a, b, c, d, e, f, g, h] = simd.transpose8(lanes);
            let least = simd.min8(
                simd.min8(simd.min8(a, b), simd.min8(c, d)),
                simd.min8(simd.min8(e, f), simd.min8(g, h)),
            );
            let greatest = simd.max8(
                simd.max8(simd.max8(a, b), simd.max8(c, d)),
                simd.max8(simd.max8(e, f), simd.max8(g, h)),
            );
            match row {
                0..3 => {
                    simd.store8(least, &mut self.origin[0][row]);
                    simd.store8(greatest, &mut self.origin[1][row]);
                }
                3..6 => {
                    simd.store8(least, &mut self.inverse_direction[0][row - 3]);
                    simd.store8(greatest, &mut self.inverse_direction[1][row - 3]);
                }
                _ => {
                    simd.store8(least, &mut self.start);
                    self.start = self.start.map(f32::next_down);
                }
            }
        }
    }
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
