//! World boxes from maps alone: of an instance's clusters, and of the instance. They hold in every pose, inside the pose
//! space or not, and need no inverse.
//!
//! Weights are not negative and sum to exactly one, so a posed vertex is a mix of its images under the bones that move it,
//! and lies in the box around those. Each image lies in the image of the box that holds, in the rest pose, the vertices
//! which that bone moves. What rounding adds is relative to the magnitudes that enter: that of the vertex function
//! ([`Asset::vertex_error`]), and of the boxes themselves fewer than 15 roundings, for which 32 u are taken. They are taken
//! once per bone, of the greatest magnitudes that it moves anywhere: the offset is most of them as a rule.
//!
//! A tighter box of a cluster, by its own bone and its pose's excess, comes with its frame
//! ([`ClusterFrame`](crate::cluster_frame::ClusterFrame)), which is made when a ray enters this one.

use crate::{
    Aabb, Affine, Asset,
    cluster_frame::SMALLEST_NORMAL,
    rest_boxes::{Images, images},
    simd::SimdLevel,
};
use restpose_formats::{
    ModelView,
    geom::round::{UNIT_ROUNDOFF, f32_above, f32_below},
};

/// Roundings of an image of a box in `f32`, twice over.
pub(crate) const IMAGE_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// Magnitudes up to this cannot have overflowed on their way.
pub(crate) const LARGEST: f32 = f32::MAX / 8.0;

/// Every finite point.
pub(crate) const EVERYWHERE: Aabb = Aabb {
    min: [f32::MIN; 3],
    max: [f32::MAX; 3],
};

/// By how much morphs displace a vertex, at most, per axis.
pub(crate) fn morph_extent(model: &ModelView, morph_weights: &[f32]) -> [f64; 3] {
    let mut extent = [0.0; 3];
    for (target, weight) in model.morph_targets.iter().zip(morph_weights) {
        for k in 0..3 {
            extent[k] += f64::from(weight.abs()) * f64::from(target.extent[k]);
        }
    }
    extent
}

/// A pose to bound an instance in.
#[derive(Clone, Copy)]
pub(crate) enum BoundedPose<'a> {
    /// Any of a stretch of a clip, or the one without a clip, by the row of clip bounds: bounded in the file, if at all.
    Clip(usize),
    /// A palette, and the [`morph_extent`].
    Given(&'a [Affine], [f64; 3]),
}

/// World box of an instance of an asset without vertex caches, from what is in the file or from its palette; `None` where
/// the file does not bound it.
pub(crate) fn posed_bounds(asset: &Asset, world_from_asset: &Affine, pose: BoundedPose) -> Option<Aabb> {
    match pose {
        BoundedPose::Clip(row) => {
            let stretch = asset.model().clip_bounds.get(row).filter(|row| row.is_known())?;
            let reach = stretch.reach.map(f64::from);
            Some(in_world(
                asset,
                world_from_asset,
                &stretch.bounds,
                reach,
                stretch.rest_reach.into(),
            ))
        }
        BoundedPose::Given(palette, morphed) => {
            let Images {
                bounds,
                reach,
                rest_reach,
            } = images(SimdLevel::detect(), asset.rest_boxes(), palette, morphed);
            if bounds.is_empty() {
                return Some(bounds);
            }
            Some(in_world(asset, world_from_asset, &bounds, reach, rest_reach))
        }
    }
}

/// The box around what a transform makes of vertices that lie, in exact arithmetic, in `bounds`. `reach` bounds `|X|·|p| +
/// |t|` over the bones, per axis, and `rest_reach` the sum of the coordinates of the `p`.
///
/// The product of transform and bone is rounded to `f32`, u of the magnitudes that enter it or the least step of numbers
/// near zero, and the vertex function adds its own error (points 1 and 2 of `cluster_frame`).
fn in_world(asset: &Asset, transform: &Affine, bounds: &Aabb, reach: [f64; 3], rest_reach: f64) -> Aabb {
    let error = asset.vertex_error() + 8.0 * UNIT_ROUNDOFF;
    let columns = transform.columns.map(|column| column.map(f64::from));
    let mut out = EVERYWHERE;
    for k in 0..3 {
        let (mut middle, mut spread, mut entering) = (columns[3][k], 0.0, columns[3][k].abs());
        for j in 0..3 {
            let (min, max) = (f64::from(bounds.min[j]), f64::from(bounds.max[j]));
            middle += columns[j][k] * 0.5 * (min + max);
            spread += columns[j][k].abs() * 0.5 * (max - min);
            entering += (columns[j][k].abs() + SMALLEST_NORMAL) * reach[j];
        }
        let spread = spread + error * entering + SMALLEST_NORMAL * (1.0 + rest_reach);
        let (min, max) = (f32_below(middle - spread), f32_above(middle + spread));
        if spread <= f64::from(LARGEST) && entering <= f64::from(LARGEST) {
            (out.min[k], out.max[k]) = (min, max);
        }
    }
    out
}
