//! Posing all vertices of a mesh at once, by [`pose_vertex`] and [`CacheState::pose_vertex`].

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Affine,
    cache::CacheState,
    simd::{Lanes, Portable, SimdLevel},
    vertex::pose_vertex,
};
use restpose_formats::ModelView;

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
    Cache(&'a CacheState),
}

/// Poses `out.len()` vertices from vertex row `first` on, as [`pose_vertex`] would each.
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
    pose_in_tasks(level, model, Mover::Cache(cache), first, out);
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
            for place in 0..out.len() {
                let posed = pose_vertex(simd, model, palette, morph_weights, (first + place) as u32);
                store(simd, posed, out, place);
            }
        }
        Mover::Cache(cache) => {
            for place in 0..out.len() {
                let posed = cache.pose_vertex(simd, model, (first + place) as u32);
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

#[cfg(test)]
mod tests;
