//! Trees that near caches do not hold, in which rays of a batch take turns at every node: hits are those of brute force.

use restpose_bake::{import::import, subdivide::subdivide};
use restpose_runtime::{Aabb, Affine, Asset, InstanceId, Posing, Ray, Scene, triangle::PreparedRay};
use restpose_tests::{baked_animation, sample_scenes};
use std::sync::Arc;

/// Of an asset, and of instances: more than a ray takes to be near (`trace/flight`).
const MANY_TRIANGLES: usize = 40_000;
const MANY_INSTANCES: usize = 40_000;

fn walker(levels: u32) -> Arc<Asset> {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    baked_animation(&subdivide(&import(&path).unwrap().animation, levels))
}

/// Rays between points of a box: they go alone.
fn rays(bounds: &Aabb, count: usize) -> Vec<Ray> {
    let mut random = fastrand::Rng::with_seed(23);
    let mut point = || std::array::from_fn(|k| bounds.min[k] + random.f32() * (bounds.max[k] - bounds.min[k]));
    (0..count).map(|_| Ray::between(point(), point())).collect()
}

type Posed = (InstanceId, u32, [[f32; 3]; 3]);

/// Compares batches with single rays and with the best of all triangles, one by one. How many hit.
#[track_caller]
fn compare(scene: &mut Scene, rays: &[Ray], posed: &[Posed]) -> usize {
    let frame = scene.commit();
    let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
    frame.closest_hits(rays, &mut hits);
    frame.any_hits(rays, &mut occluded);
    for ((ray, hit), occluded) in rays.iter().zip(&hits).zip(occluded) {
        assert_eq!(*hit, frame.closest_hit(ray), "{ray:?}");
        assert_eq!(hit.is_some(), occluded, "{ray:?}");
        let prepared = PreparedRay::new(ray).unwrap();
        let mut best: Option<(f32, InstanceId, u32)> = None;
        for (instance, triangle, corners) in posed {
            if let Some(found) = prepared.intersect(corners)
                && best.is_none_or(|(t, ..)| found.t < t)
            {
                best = Some((found.t, *instance, *triangle));
            }
        }
        assert_eq!(hit.map(|hit| (hit.t, hit.instance, hit.triangle)), best, "{ray:?}");
    }
    hits.iter().flatten().count()
}

#[test]
fn rays_take_turns_in_a_large_asset() {
    let asset = walker(4);
    assert!(asset.model().triangles.len() > MANY_TRIANGLES);
    let mut scene = Scene::new();
    let id = scene.add(&asset);
    for posing in [Posing::Recomputed, Posing::Remembered, Posing::Whole] {
        scene.set_posing(id, posing).unwrap();
        let clip = asset.model().clips[0];
        scene.play(id, 0, 0.4 * clip.end_seconds).unwrap();
        let frame = scene.commit();
        let posed: Vec<Posed> = (0..asset.model().triangles.len() as u32)
            .map(|triangle| (id, triangle, frame.triangle(id, triangle).unwrap()))
            .collect();
        let rays = rays(&frame.bounds(), 300);
        let hits = compare(&mut scene, &rays, &posed);
        assert!((30..300).contains(&hits), "{posing:?}: {hits}");
    }
}

#[test]
fn rays_take_turns_among_many_instances() {
    let asset = walker(0);
    let mut scene = Scene::new();
    let side = (MANY_INSTANCES as f64).sqrt() as usize;
    let ids: Vec<InstanceId> = (0..MANY_INSTANCES).map(|_| scene.add(&asset)).collect();
    let size = {
        let bounds = scene.commit().instance_bounds(ids[0]).unwrap();
        [0, 2].map(|k| 1.5 * (bounds.max[k] - bounds.min[k]))
    };
    let place = |at: usize| [(at % side) as f32 * size[0], 0.0, (at / side) as f32 * size[1]];
    for (at, id) in ids.iter().enumerate() {
        scene.set_transform(*id, Affine::from_translation(place(at))).unwrap();
    }
    let frame = scene.commit();
    assert!(frame.stats().top_level_nodes > 4096);
    // Brute force is over instances near a row of them, along which the rays go.
    let row = side / 2;
    let near: Vec<InstanceId> = (0..6).map(|at| ids[row * side + at]).collect();
    let posed: Vec<Posed> = near
        .iter()
        .flat_map(|id| {
            (0..asset.model().triangles.len() as u32)
                .map(move |triangle| (*id, triangle, frame.triangle(*id, triangle).unwrap()))
        })
        .collect();
    let bounds = frame
        .instance_bounds(near[0])
        .unwrap()
        .union(frame.instance_bounds(near[5]).unwrap());
    let rays = rays(&bounds, 600);
    let hits = compare(&mut scene, &rays, &posed);
    assert!((100..600).contains(&hits), "{hits}");
}
