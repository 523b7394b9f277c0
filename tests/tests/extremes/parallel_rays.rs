//! Rays along an axis cost what others do: bones that do not turn have local spaces in which such a ray is parallel to two
//! pairs of planes of every box.

use restpose_formats::TreeKind;
use restpose_runtime::{Asset, Posing, Ray, Scene, TraceCounters, triangle::PreparedRay};
use restpose_tests::{baked_asset, kd_twin, sample_scenes};
use std::sync::Arc;

/// Of rays along all axes, the triangles that they test, and of the same rays a little turned.
fn tests(asset: &Arc<Asset>, random: &mut fastrand::Rng) -> [u64; 2] {
    let mut scene = Scene::new();
    let id = scene.add(asset);
    scene.set_posing(id, Posing::Recomputed).unwrap();
    let mut tests = [0; 2];
    for round in 0..8 {
        let clip = asset.model().clips[0];
        let share = round as f32 / 8.0;
        let seconds = clip.start_seconds + share * (clip.end_seconds - clip.start_seconds);
        scene.play(id, 0, seconds).unwrap();
        let frame = scene.commit();
        let posed: Vec<_> = (0..asset.model().triangles.len() as u32)
            .map(|triangle| frame.triangle(id, triangle).unwrap())
            .collect();
        let bounds = frame.bounds();
        let [size_x, size_y, size_z] = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]);
        let size = size_x.max(size_y).max(size_z);
        for _ in 0..200 {
            let point: [f32; 3] =
                std::array::from_fn(|k| bounds.min[k] + random.f32() * (bounds.max[k] - bounds.min[k]));
            let axis = random.usize(..3);
            let sign = if random.bool() { 1.0 } else { -1.0 };
            for (turned, tests) in [0.0, 1e-3].iter().zip(&mut tests) {
                let mut direction = [*turned * sign, -turned, *turned];
                direction[axis] = sign;
                let mut origin = point;
                for k in 0..3 {
                    origin[k] -= direction[k] * size;
                }
                let ray = Ray::new(origin, direction);
                let mut counters = TraceCounters::default();
                let hit = frame.closest_hit_counted(&ray, &mut counters);
                *tests += counters.triangle_tests;
                // The best of all triangles, one by one.
                let mut best = None;
                let prepared = PreparedRay::new(&ray).unwrap();
                for (triangle, corners) in (0..).zip(&posed) {
                    if let Some(found) = prepared.intersect(corners)
                        && best.is_none_or(|(t, _)| found.t < t)
                    {
                        best = Some((found.t, triangle));
                    }
                }
                assert_eq!(hit.map(|hit| (hit.t, hit.triangle)), best, "{ray:?}");
            }
        }
    }
    tests
}

#[test]
fn rays_along_an_axis_test_no_more_triangles_than_others() {
    let mut random = fastrand::Rng::with_seed(71);
    for path in sample_scenes() {
        let (_, asset) = baked_asset(&path);
        for asset in [Arc::clone(&asset), kd_twin(&asset)] {
            let [along, turned] = tests(&asset, &mut random);
            let kind: TreeKind = asset.model().meta.tree;
            // Few are tested at all, and a ray that is turned passes others.
            let most = turned + turned / 4 + 100;
            assert!(
                along <= most,
                "{}, {kind:?}: {along} tests along axes, {turned} beside them",
                path.display()
            );
        }
    }
}
