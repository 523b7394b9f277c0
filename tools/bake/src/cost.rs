//! What rays are expected to cost, in steps of a kd-tree: how the baker compares structures before it has traced a ray.

use restpose_formats::geom::Aabb;
use restpose_runtime::build::{KdSettings, KdTree, sah_cost};

/// Fuzzy trees are built with the builder's own constants. A test poses three vertices first, so one could think it worth
/// more steps than the 1.5 of a tree over posed triangles; but a leaf tests each triangle's own box before.
///
/// Measured on CHICKEN in 8 segments, primary rays, intersection costs of 4, 2 and 1.2: 16.0, 14.0 and 13.0 steps, 2.4,
/// 2.6 and 2.8 tests, 14.1, 11.6 and 9.5 MB; the times lie within their noise.
pub(crate) fn fuzzy_tree() -> KdSettings {
    KdSettings::default()
}

/// Steps that it takes to bring a ray into a cluster: the top level's share and the ray's transformation.
const ENTRY_COST: f64 = 8.0;

/// The expected steps of a ray that meets the box around all clusters, mean over the key frames.
///
/// `clusters` are trees with the box of their contents at each key; the chance to enter one is the ratio of surfaces.
pub(crate) fn expected_cost<'a>(clusters: impl Iterator<Item = (&'a KdTree, &'a [Aabb])> + Clone) -> f64 {
    let key_count = clusters.clone().map(|(_, bounds)| bounds.len()).max().unwrap_or(0);
    let mut wholes = vec![Aabb::EMPTY; key_count];
    for (key, bounds) in clusters.clone().flat_map(|(_, bounds)| bounds.iter().enumerate()) {
        wholes[key] = wholes[key].union(*bounds);
    }
    let mut cost = 0.0;
    for (tree, bounds) in clusters.filter(|(tree, _)| !tree.nodes.is_empty()) {
        let inside = ENTRY_COST + sah_cost(&tree.nodes, &tree.bounds, &fuzzy_tree());
        let shares = bounds.iter().zip(&wholes).map(|(own, whole)| share(own, whole));
        cost += inside * shares.sum::<f64>();
    }
    cost / key_count.max(1) as f64
}

/// The chance that a ray that meets `whole` meets `own`, which lies inside.
fn share(own: &Aabb, whole: &Aabb) -> f64 {
    let ratio = own.surface_area() / whole.surface_area();
    if ratio.is_finite() { ratio } else { 1.0 }
}

/// Nanoseconds of a step. Measured on a walking figure, random rays, one thread: 0.5 µs for 13 steps, 2.5 tests and the
/// rest.
const STEP_NANOSECONDS: f64 = 20.0;

/// Nanoseconds per triangle of building the tree of free motion: the exact sweep takes 1.2 ms for a thousand boxes and
/// 170 ms for a hundred thousand.
const REBUILD_NANOSECONDS: f64 = 1_500.0;

/// Whether a frame of `rays_per_frame` rays is cheaper with a tree built for it than with fuzzy trees, by their expected
/// costs.
pub(crate) fn is_free(fuzzy: f64, rebuilt: f64, triangles: usize, rays_per_frame: f64) -> bool {
    (fuzzy - rebuilt) * STEP_NANOSECONDS * rays_per_frame > triangles as f64 * REBUILD_NANOSECONDS
}
