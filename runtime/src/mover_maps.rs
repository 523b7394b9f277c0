//! How bones move against a cluster in a pose, for boxes that follow it.

use crate::{
    relative_motions::RelativeMotions,
    simd::{Doubles, Lanes, weighted_sum},
};
use restpose_formats::{
    geom::round::{UNIT_ROUNDOFF, f32_above},
    rows::{MAX_MOVERS, RestLattice},
};

/// The motion of one bone against the cluster: `E·q + d` in steps of the cluster's [`RestLattice`], for q on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MoverMap {
    /// Those of E, and d.
    pub columns: [[f32; 3]; 4],
}

impl MoverMap {
    const STILL: Self = Self { columns: [[0.0; 3]; 4] };
}

/// The motions of a cluster's movers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoverMaps {
    pub maps: [MoverMap; MAX_MOVERS],
    /// By how much morphs displace a rest position, at most, in steps.
    pub morphed: [f32; 3],
}

/// Greatest coordinate of the lattice.
const WIDTH: f64 = u16::MAX as f64;

/// Steps that no plane of a posed box is beyond, where boxes are relied upon: 256 times the lattice.
pub(crate) const MOST_STEPS: f32 = (1u32 << 24) as f32;

/// Units of roundoff, relative to the greatest magnitudes that enter, that a plane is off by. Six roundings are in each
/// motion, eight movers add up to eight, and the ray's way to the plane takes nine (`cluster_frame`): with those of the weights
/// about 26; more than twice that is taken.
const PLANE_ERROR: f64 = 64.0 * UNIT_ROUNDOFF;

impl MoverMaps {
    /// Of clusters without nodes that follow.
    pub(crate) const NONE: Self = Self {
        maps: [MoverMap::STILL; MAX_MOVERS],
        morphed: [0.0; 3],
    };

    /// Error of boxes that must not be relied upon.
    pub(crate) const UNKNOWN: [f64; 3] = [f64::INFINITY; 3];

    /// Of the relative motions in a pose; and what bounds, per axis and in local space, by how much a fuzzy position leaves the
    /// box that is computed for it: what rounding adds, [`Self::UNKNOWN`] where boxes must not be relied upon.
    ///
    /// # Why the error bounds what is left out
    ///
    /// `E·x + d` is off by at most `|x|₁` times the error of an entry and that of d, x being a rest position, which the sum of
    /// the origin's magnitudes and three widths bounds. Weights of movers sum to one at most, up to half a unit each of the
    /// row's. In `f32` a plane is off by some roundings of the magnitudes that enter: the lattice's width, and the motions'
    /// greatest ones, once for the middle and twice for the half.
    #[inline(always)]
    pub(crate) fn new<S: Lanes>(
        simd: S,
        lattice: &RestLattice,
        relative: &RelativeMotions,
        morph_extent: [f64; 3],
    ) -> (Self, [f64; 3]) {
        let (mut out, mut error) = (Self::NONE, Self::UNKNOWN);
        if !lattice.is_usable() {
            return (out, error);
        }
        let step = f64::from(lattice.step);
        let origin = lattice.origin.map(f64::from);
        let mut farthest = 0.0;
        for k in 0..3 {
            farthest += origin[k].abs() + WIDTH * step + morph_extent[k];
        }
        out.morphed = morph_extent.map(|x| f32_above(x / step));
        let width = out.morphed.map(|x| WIDTH + f64::from(x));
        let [a, b, c] = width;
        let (mut reach, mut exact) = (Doubles::new(simd, &[a, b, c, 0.0]), 0.0);
        for (map, motion) in out.maps.iter_mut().zip(&relative.motions) {
            let linear = Doubles::three(simd, &motion.columns);
            let at_origin = Doubles::new(simd, &motion.offset) + weighted_sum(linear, origin);
            let offset = at_origin.over(step);
            let [x, y, z] = linear;
            map.columns = [x.to_point(), y.to_point(), z.to_point(), offset.to_point()];
            let turned = weighted_sum([x.rounded().abs(), y.rounded().abs(), z.rounded().abs()], width);
            reach = reach + (turned + offset.rounded().abs()) * 3.0;
            exact += 2.0 * (motion.entry_error * farthest + motion.offset_error);
        }
        let reach = reach.numbers();
        for k in 0..3 {
            let bound = PLANE_ERROR * reach[k] * step + exact;
            if reach[k] <= f64::from(MOST_STEPS) && bound.is_finite() {
                error[k] = bound;
            }
        }
        (out, error)
    }
}
