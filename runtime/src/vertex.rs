//! The vertex function: the one way in which a vertex of the rest pose becomes a vertex of the current pose.

use crate::{cluster_frame::SMALLEST_NORMAL, simd::Lanes};
use restpose_formats::{
    ModelView,
    geom::Affine,
    rows::{ClusterRow, InfluenceRow},
};

/// Poses one vertex: its coordinates in three lanes, and a fourth that means nothing.
///
/// Morph first: `p = rest + Σ weight·delta` over the vertex's deltas in row order. Then skin: one influence gives
/// `X·p`, several give `Σ w·(X·p)` in row order, each product rounded as [`Affine::transform_point`] says. All in `f32`
/// without contraction, so every caller gets the same bits.
///
/// `vertex` is a vertex row other than the closing one; `palette` has a map per bone row and `morph_weights` a weight
/// per morph target row.
#[inline(always)]
pub(crate) fn pose_vertex<S: Lanes>(
    simd: S,
    model: &ModelView,
    palette: &[Affine],
    morph_weights: &[f32],
    vertex: u32,
) -> S::F4 {
    let [row, next] = [0, 1].map(|place| &model.vertices[vertex as usize + place]);
    let influences = &model.influences[row.influence_first as usize..next.influence_first as usize];
    let p = if model.morph_first.is_empty() {
        row.position_rest
    } else {
        morph(model, morph_weights, vertex as usize)
    };
    skin(simd, palette, influences, p)
}

fn morph(model: &ModelView, weights: &[f32], vertex: usize) -> [f32; 3] {
    let mut p = model.vertices[vertex].position_rest;
    for delta in model.morph_deltas_of(vertex) {
        let weight = weights[delta.target as usize];
        for k in 0..3 {
            p[k] += weight * delta.delta[k];
        }
    }
    p
}

#[inline(always)]
fn skin<S: Lanes>(simd: S, palette: &[Affine], influences: &[InfluenceRow], p: [f32; 3]) -> S::F4 {
    let p = [simd.splat4(p[0]), simd.splat4(p[1]), simd.splat4(p[2])];
    match influences {
        [only] => transform(simd, &palette[only.bone as usize], p),
        // The most common number, without a loop.
        [a, b, c, d] => {
            let sum = add_moved(simd, palette, a, p, simd.splat4(0.0));
            let sum = add_moved(simd, palette, b, p, sum);
            let sum = add_moved(simd, palette, c, p, sum);
            add_moved(simd, palette, d, p, sum)
        }
        more => {
            let mut sum = simd.splat4(0.0);
            for influence in more {
                sum = add_moved(simd, palette, influence, p, sum);
            }
            sum
        }
    }
}

#[inline(always)]
fn add_moved<S: Lanes>(simd: S, palette: &[Affine], influence: &InfluenceRow, p: [S::F4; 3], sum: S::F4) -> S::F4 {
    let moved = transform(simd, &palette[influence.bone as usize], p);
    simd.add4(sum, simd.mul4(simd.splat4(influence.weight), moved))
}

/// As [`Affine::transform_point`], for a point of three splats.
#[inline(always)]
pub(crate) fn transform<S: Lanes>(simd: S, map: &Affine, [x, y, z]: [S::F4; 3]) -> S::F4 {
    let [c0, c1, c2, c3] = columns4(simd, map);
    let sum = simd.add4(simd.mul4(c0, x), simd.mul4(c1, y));
    simd.add4(simd.add4(sum, simd.mul4(c2, z)), c3)
}

/// The columns of a map, three numbers each, and a fourth that means nothing.
#[inline(always)]
pub(crate) fn columns4<S: Lanes>(simd: S, map: &Affine) -> [S::F4; 4] {
    // Four numbers from the beginning of a column, of which the fourth is the next column's, or up to the end of the last.
    let numbers: &[f32; 12] = bytemuck::cast_ref(map);
    let from = |first: usize| numbers[first..].first_chunk::<4>().unwrap_or(&[0.0; 4]);
    [
        simd.load4(from(0)),
        simd.load4(from(3)),
        simd.load4(from(6)),
        simd.rotate4(simd.load4(from(8))),
    ]
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
