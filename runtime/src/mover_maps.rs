//! How bones move against a cluster in a pose, for boxes that follow it.

use crate::excess::inverse_error;
use restpose_formats::{
    geom::{
        Affine,
        round::{UNIT_ROUNDOFF, f32_above},
    },
    rows::{ClusterBoneRow, MAX_MOVERS, RestLattice},
};

/// The motion of one bone against the cluster: `E·q + d` in steps of the cluster's [`RestLattice`], for q on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MoverMap {
    /// Rows of E.
    pub linear: [[f32; 3]; 3],
    /// d.
    pub offset: [f32; 3],
}

impl MoverMap {
    const STILL: Self = Self {
        linear: [[0.0; 3]; 3],
        offset: [0.0; 3],
    };
}

/// The motions of a cluster's movers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoverMaps {
    pub maps: [MoverMap; MAX_MOVERS],
    /// By how much morphs displace a rest position, at most, in steps.
    pub morphed: [f32; 3],
    /// Bounds, per axis and in local space, by how much a fuzzy position leaves the box that is computed for it: what
    /// rounding adds. Infinite where boxes must not be relied upon.
    pub error: [f64; 3],
}

/// Greatest coordinate of the lattice.
const WIDTH: f64 = u16::MAX as f64;

/// Steps that no plane of a posed box is beyond, where boxes are relied upon: 256 times the lattice.
pub(crate) const MOST_STEPS: f32 = (1u32 << 24) as f32;

/// Units of roundoff, relative to the greatest magnitudes that enter, that a plane is off by. Eight movers add up to 8 + 8
/// roundings, and six are in each motion; twice that is taken.
const PLANE_ERROR: f64 = 64.0 * UNIT_ROUNDOFF;

/// 2⁻⁴⁸: as in `excess`, bounds the `f64` roundings of a relative motion relative to the magnitudes that enter it.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

impl MoverMaps {
    /// Of clusters without nodes that follow.
    pub(crate) const NONE: Self = Self {
        maps: [MoverMap::STILL; MAX_MOVERS],
        morphed: [0.0; 3],
        error: [f64::INFINITY; 3],
    };

    /// The motions in a pose. `inverse` is what [`invert_frame`](crate::invert_frame) made of the own bone's map;
    /// `palette` has no instance transform in it.
    ///
    /// # Why the error bounds what is left out
    ///
    /// With the computed inverse L = X⁻¹ + δ, `|E·x + d|` in exact arithmetic differs from the computed one by at most
    /// `slack·(linear·|x|₁ + offset)` as in `excess`, x being a rest position, which the sum of the origin's magnitudes and
    /// three widths bounds. Weights of movers sum to one at most, up to half a unit each of the row's. In `f32` a plane is
    /// off by some roundings of the magnitudes that enter: the lattice's width, and the motions' greatest ones, once for the
    /// middle and twice for the half.
    pub(crate) fn new(
        lattice: &RestLattice,
        cluster_bones: &[ClusterBoneRow],
        own: u32,
        inverse: &[[f64; 3]; 3],
        palette: &[Affine],
        morph_extent: [f64; 3],
    ) -> Self {
        let mut out = Self::NONE;
        if !lattice.is_usable() {
            return out;
        }
        let columns = |bone: u32| palette[bone as usize].columns.map(|column| column.map(f64::from));
        let norm = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
        let own_columns = columns(own);
        let inverse_norm = norm(inverse.as_flattened());
        let slack = 2.0 * inverse_error(inverse, &own_columns) + ROUNDING;
        let step = f64::from(lattice.step);
        let origin = lattice.origin.map(f64::from);
        let farthest = (0..3)
            .map(|k| origin[k].abs() + WIDTH * step + morph_extent[k])
            .sum::<f64>();
        let turned = |v: [f64; 3], k: usize| inverse[k][0] * v[0] + inverse[k][1] * v[1] + inverse[k][2] * v[2];
        let own_offset = norm(&own_columns[3]);
        out.morphed = morph_extent.map(|x| f32_above(x / step));
        let width = out.morphed.map(|x| WIDTH + f64::from(x));
        let (mut reach, mut exact) = (width, 0.0);
        let movers = cluster_bones.iter().filter(|row| row.bone != own);
        for (map, row) in out.maps.iter_mut().zip(movers) {
            let x = columns(row.bone);
            let away: [f64; 3] = std::array::from_fn(|i| x[3][i] - own_columns[3][i]);
            for k in 0..3 {
                let e: [f64; 3] = std::array::from_fn(|j| turned(x[j], k) - if j == k { 1.0 } else { 0.0 });
                let at_origin = turned(away, k) + (e[0] * origin[0] + e[1] * origin[1] + e[2] * origin[2]);
                map.linear[k] = e.map(|entry| entry as f32);
                map.offset[k] = (at_origin / step) as f32;
                let turned: f64 = (0..3).map(|j| f64::from(map.linear[k][j].abs()) * width[j]).sum();
                reach[k] += 3.0 * (turned + f64::from(map.offset[k].abs()));
            }
            let linear = inverse_norm * norm(x[..3].as_flattened()) + 1.0;
            exact += 2.0 * slack * (linear * farthest + inverse_norm * (norm(&x[3]) + own_offset));
        }
        for k in 0..3 {
            let error = PLANE_ERROR * reach[k] * step + exact;
            if reach[k] <= f64::from(MOST_STEPS) && error.is_finite() {
                out.error[k] = error;
            }
        }
        out
    }
}
