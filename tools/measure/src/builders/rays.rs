use super::scenes::Triangle;
use crate::view::View;
use restpose_runtime::{Aabb, Ray};

/// Points that a camera is fitted to: of larger scenes, as many spread evenly.
const MOST_POINTS: usize = 1 << 20;

/// Camera rays of a picture that the scene fills, rows from the top.
pub(super) fn primary_rays(triangles: &[Triangle], side: u32) -> Vec<Ray> {
    let step = triangles.len().div_ceil(MOST_POINTS / 3).max(1);
    let points: Vec<[f32; 3]> = triangles.iter().step_by(step).flatten().copied().collect();
    View::filled_by(&points).rays(side)
}

/// Rays from point to point of a box twice the scene's size.
pub(super) fn random_rays(triangles: &[Triangle], count: u32, seed: u64) -> Vec<Ray> {
    let bounds = Aabb::around(triangles.iter().flatten().copied());
    let center = bounds.center();
    let half: [f32; 3] = std::array::from_fn(|k| 0.5 * bounds.max[k] - 0.5 * bounds.min[k]);
    // A flat scene, too, is met from all sides.
    let largest = half[0].max(half[1]).max(half[2]);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut point = || -> [f32; 3] {
        std::array::from_fn(|k| center[k] + 2.0 * (half[k] + 0.1 * largest) * (2.0 * random.f32() - 1.0))
    };
    (0..count)
        .map(|_| {
            let (from, to) = (point(), point());
            Ray::new(from, std::array::from_fn(|k| to[k] - from[k]))
        })
        .collect()
}
