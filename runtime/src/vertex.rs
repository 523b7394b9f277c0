//! The vertex function: the one way in which a vertex of the rest pose becomes a vertex of the current pose.

use crate::cluster_frame::SMALLEST_NORMAL;
use restpose_formats::{ModelView, geom::Affine, rows::ClusterRow};

/// Poses one vertex.
///
/// Morph first: `p = rest + Σ weight·delta` over the vertex's deltas in row order. Then skin: one influence gives
/// `X·p`, several give `Σ w·(X·p)` in row order, each product rounded as [`Affine::transform_point`] says. All in `f32`
/// without contraction, so every caller gets the same bits.
///
/// `vertex` is a vertex row other than the closing one; `palette` has a map per bone row and `morph_weights` a weight
/// per morph target row.
#[inline]
pub(crate) fn pose_vertex(model: &ModelView, palette: &[Affine], morph_weights: &[f32], vertex: u32) -> [f32; 3] {
    let vertex = vertex as usize;
    let mut p = model.vertices[vertex].position_rest;
    for delta in model.morph_deltas_of(vertex) {
        let weight = morph_weights[delta.target as usize];
        for k in 0..3 {
            p[k] += weight * delta.delta[k];
        }
    }
    let influences = model.influences_of(vertex);
    if let [only] = influences {
        return palette[only.bone as usize].transform_point(p);
    }
    let mut sum = [0.0; 3];
    for influence in influences {
        let moved = palette[influence.bone as usize].transform_point(p);
        for k in 0..3 {
            sum[k] += influence.weight * moved[k];
        }
    }
    sum
}

/// The rows of a cluster's bones, or tracks, and the greatest magnitudes of the points that each of them moves.
#[inline(always)]
pub(crate) fn moved<'a>(
    model: &ModelView<'a>,
    cluster: &ClusterRow,
) -> impl Iterator<Item = (u32, [f64; 3])> + use<'a> {
    let rows = &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
    rows.iter().map(|row| {
        // A morph that underflows is off by up to 2⁻¹⁵⁰ before the bone enlarges it: u times the last term.
        let [x, y, z] = row.extent();
        let wide = |x: f32| f64::from(x) + SMALLEST_NORMAL;
        (row.bone, [wide(x), wide(y), wide(z)])
    })
}

/// `f32` roundings on the longest way from a rest position to a posed one: bounds, with
/// [`gamma`](restpose_formats::geom::round::gamma), the vertex function's error relative to `Σ w·(|X|·|p| + |t|)`.
///
/// A morph delta passes its product and up to all later sums; the product with X and its sums are four; the weight is
/// one; the sum over influences is one each.
pub(crate) fn rounding_count(model: &ModelView) -> u32 {
    let longest = |starts: &mut dyn Iterator<Item = u32>| {
        let mut previous = 0;
        starts
            .map(|start| start - std::mem::replace(&mut previous, start))
            .max()
            .unwrap_or(0)
    };
    let influences = longest(&mut model.vertices.iter().map(|row| row.influence_first));
    let morphs = longest(&mut model.morph_first.iter().copied());
    morphs + 1 + 4 + 1 + influences
}
