//! World boxes of instances throughout a time interval, in which transform and pose go from one state to another
//! ([`Motion`]).

use crate::{
    Aabb, Affine, Asset, Pose,
    cache::CacheTime,
    cluster_frame::SMALLEST_NORMAL,
    motion::Motion,
    posed_bounds::{BoundedPose, EVERYWHERE, IMAGE_ERROR, LARGEST, morph_extent, posed_bounds},
    vertex::moved,
};
use restpose_formats::{
    geom::round::{f32_above, f32_below},
    rows::NONE,
};

/// World box of an instance of an asset without vertex caches throughout a time interval.
///
/// With T(s) and X(s) linear in s, `T(s)·X(s)·p` lies on a parabola whose control points are mixes of `T₀X₀p`, `T₀X₁p`,
/// `T₁X₀p` and `T₁X₁p`: the box around the boxes of these holds, where p ranges over what the morph weights of both ends reach.
/// Rounding T(s) and X(s) to `f32` takes three u of what enters, which [`IMAGE_ERROR`] and `in_world` leave room for; where
/// their entries are no normal numbers it takes 2⁻¹⁴⁹ each, so what enters is counted with them greater by the least normal.
pub(crate) fn motion_bounds(asset: &Asset, begin: &Affine, motion: &Motion) -> Aabb {
    let transforms = [begin, motion.end.transform()];
    // Morph weights move as well: each palette meets those of both ends.
    let morphed = morph_extent(asset.model(), &motion.largest_weights());
    let poses = motion
        .poses()
        .iter()
        .flat_map(|pose| transforms.map(|transform| (transform, pose)));
    poses.fold(Aabb::EMPTY, |bounds, (transform, pose)| {
        let own = posed_bounds(asset, transform, BoundedPose::Given(&pose.palette, morphed));
        bounds.union(own.unwrap_or(EVERYWHERE))
    })
}

/// A box of an instance with vertex caches at an end of a time interval, or at a key within, widened by what rounding does to
/// vertices on their way; everything where something may overflow. `pose` and `frames` are those of the box, `frames` by
/// cache row: what stands between its keys enters as what stands at them.
///
/// T(s) and X(s) are each off by three u of `(1 − s)|a| + s|b|`, or by 2⁻¹⁴⁹, their product by one more u, the vertex by γ₅,
/// and the vertices that the box is around, where it is around posed ones, by the last two as well: 18 u of `|T||X||q|`, for
/// which 32 are taken. Products that cancel are why the rounded maps' own magnitudes do not do.
pub(crate) fn widened_for_motion(
    asset: &Asset,
    bounds: &Aabb,
    transform: &Affine,
    pose: &Pose,
    frames: &[Option<CacheTime>],
) -> Aabb {
    let model = asset.model();
    let mut entering = [0.0f64; 3];
    let mut enter = |bone: u32, extent: [f64; 3]| {
        let image = magnitudes(transform, magnitudes(&pose.palette[bone as usize], extent));
        entering = std::array::from_fn(|k| entering[k].max(image[k]));
    };
    let morphed = morph_extent(model, &pose.morph_weights);
    for (bone, extent) in asset.rest_boxes().extents() {
        enter(bone, std::array::from_fn(|k| extent[k] + morphed[k]));
    }
    for (cache, time) in model.caches.iter().zip(frames) {
        let Some(time) = time else { continue };
        let segment = &model.segments[time.segment as usize];
        for cluster in &model.clusters[segment.cluster_first as usize..][..segment.cluster_count as usize] {
            for key in time.keys {
                for (row, extent) in moved(model, cluster) {
                    let track = &model.tracks[row as usize];
                    let local =
                        std::array::from_fn(|k| f64::from(track.origin[k].abs()) + f64::from(track.step) * extent[k]);
                    let extent = match track.key_first {
                        NONE => local,
                        first => magnitudes(&model.keys[(first + key) as usize].map(), local),
                    };
                    enter(cache.bone, extent);
                }
            }
        }
    }
    if !entering.iter().all(|x| *x <= f64::from(LARGEST)) {
        return EVERYWHERE;
    }
    let spread = entering.map(|x| IMAGE_ERROR * x + SMALLEST_NORMAL);
    Aabb {
        min: std::array::from_fn(|k| f32_below(f64::from(bounds.min[k]) - spread[k])),
        max: std::array::from_fn(|k| f32_above(f64::from(bounds.max[k]) + spread[k])),
    }
}

/// `|X||p| + |t|`, with every number of the map greater by the least normal one.
fn magnitudes(map: &Affine, extent: [f64; 3]) -> [f64; 3] {
    let [a, b, c, d] = map
        .columns
        .map(|column| column.map(|x| f64::from(x.abs()) + SMALLEST_NORMAL));
    std::array::from_fn(|k| a[k] * extent[0] + b[k] * extent[1] + c[k] * extent[2] + d[k])
}
