//! Posing all vertices of a mesh at once, with the bits that [`pose_vertex`](crate::vertex::pose_vertex) and
//! [`CacheState::pose_vertex`] give one by one.
//!
//! A vertex's coordinates are three lanes: each lane computes what the scalar function computes for its coordinate, in
//! the same order, nothing fused; the fourth lane means nothing.

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Affine,
    cache::{CacheSource, CacheState},
    simd::{Lanes, Portable, SimdLevel},
};
use restpose_formats::{ModelView, rows::InfluenceRow};

/// Vertices of one task.
const TASK: usize = 4096;

/// What moves the vertices.
#[derive(Clone, Copy)]
enum Mover<'a> {
    /// Bones and morph targets.
    Bones {
        palette: &'a [Affine],
        morph_weights: &'a [f32],
    },
    Cache(CacheSource<'a>),
}

/// Poses `out.len()` vertices from vertex row `first` on, as [`pose_vertex`](crate::vertex::pose_vertex) would each.
pub(crate) fn pose_vertices(
    level: SimdLevel,
    model: &ModelView,
    palette: &[Affine],
    morph_weights: &[f32],
    first: usize,
    out: &mut [[f32; 3]],
) {
    let mover = Mover::Bones { palette, morph_weights };
    pose_in_tasks(level, model, mover, first, out);
}

/// Poses `out.len()` vertices of a cache's part from vertex row `first` on, as [`CacheState::pose_vertex`] would each.
pub(crate) fn pose_cached_vertices(
    level: SimdLevel,
    model: &ModelView,
    cache: &CacheState,
    first: usize,
    out: &mut [[f32; 3]],
) {
    match cache.source() {
        Some(source) => pose_in_tasks(level, model, Mover::Cache(source), first, out),
        None => out.fill([f32::NAN; 3]),
    }
}

/// On all cores where that is worth it.
fn pose_in_tasks(level: SimdLevel, model: &ModelView, mover: Mover, first: usize, out: &mut [[f32; 3]]) {
    #[cfg(feature = "parallel")]
    if out.len() > TASK {
        use rayon::prelude::*;
        let tasks = out.par_chunks_mut(TASK).enumerate();
        tasks.for_each(|(task, out)| pose_some(level, model, mover, first + task * TASK, out));
        return;
    }
    for (task, out) in out.chunks_mut(TASK).enumerate() {
        pose_some(level, model, mover, first + task * TASK, out);
    }
}

fn pose_some(level: SimdLevel, model: &ModelView, mover: Mover, first: usize, out: &mut [[f32; 3]]) {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, model: &ModelView, mover: Mover, first: usize, out: &mut [[f32; 3]]) {
            pose_with(simd, model, mover, first, out);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, model, mover, first, out) };
    }
    pose_with(Portable, model, mover, first, out);
}

#[inline(always)]
fn pose_with<S: Lanes>(simd: S, model: &ModelView, mover: Mover, first: usize, out: &mut [[f32; 3]]) {
    match mover {
        Mover::Bones { palette, morph_weights } => {
            let rows = &model.vertices[first..=first + out.len()];
            for (place, [row, next]) in rows.array_windows().enumerate() {
                let influences = &model.influences[row.influence_first as usize..next.influence_first as usize];
                let p = if model.morph_first.is_empty() {
                    row.position_rest
                } else {
                    morph(model, morph_weights, first + place)
                };
                store(simd, skin(simd, palette, influences, p), out, place);
            }
        }
        Mover::Cache(source) => {
            for place in 0..out.len() {
                let posed = blend_keys(simd, model, &source, first + place);
                store(simd, posed, out, place);
            }
        }
    }
}

/// Writes the three coordinates, and where there is a next vertex, over its first one, whose turn is still to come.
#[inline(always)]
fn store<S: Lanes>(simd: S, posed: S::F4, out: &mut [[f32; 3]], place: usize) {
    let lanes = simd.store4(posed);
    match out.as_flattened_mut()[3 * place..].first_chunk_mut::<4>() {
        Some(four) => *four = lanes,
        None => out[place].copy_from_slice(&lanes[..3]),
    }
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

#[inline(always)]
fn blend_keys<S: Lanes>(simd: S, model: &ModelView, source: &CacheSource, vertex: usize) -> S::F4 {
    let row = &model.key_vertices[(vertex as u32).wrapping_add(source.key_vertex_shift) as usize];
    let [a, b] = source.tracks[(row.track - source.track_first) as usize].maps();
    let [p, q] = [
        row.stored(model.key_words, source.keys[0]),
        row.stored(model.key_words, source.keys[1]),
    ];
    let a = transform(simd, a, [simd.splat4(p[0]), simd.splat4(p[1]), simd.splat4(p[2])]);
    let b = transform(simd, b, [simd.splat4(q[0]), simd.splat4(q[1]), simd.splat4(q[2])]);
    simd.add4(a, b)
}

/// As [`Affine::transform_point`], for a point of three splats.
#[inline(always)]
fn transform<S: Lanes>(simd: S, map: &Affine, [x, y, z]: [S::F4; 3]) -> S::F4 {
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

#[cfg(test)]
mod tests;
