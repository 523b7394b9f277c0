//! Same input, same bytes and same hits, whatever the number of threads.

use restpose_bake::{
    BakeSettings, NoProgress, PoseSpace, bake,
    import::import,
    subdivide::subdivide,
    verify::{Oracle, Rays},
};
use restpose_formats::Bounds;
use restpose_runtime::{Hit, Ray, Scene};
use restpose_tests::{baked_asset, source_scenes};

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(work)
}

#[test]
fn bakes_are_the_same_bytes_on_one_and_two_threads() {
    for path in source_scenes() {
        // Subdivided so that there is more than one task of triangles.
        let animation = subdivide(&import(&path).unwrap().animation, 1);
        for (bounds, pose_space) in [
            (Bounds::Sampled, PoseSpace::Clips),
            (Bounds::Envelope, PoseSpace::Clips),
            (Bounds::Envelope, PoseSpace::Arbitrary),
        ] {
            let settings = BakeSettings {
                bounds,
                pose_samples: pose_space.is_random().then_some(50),
                pose_space,
                ..BakeSettings::default()
            };
            let bytes = |threads| {
                on_threads(threads, || {
                    restpose_formats::write(&bake(&animation, &settings, &NoProgress).unwrap().model).unwrap()
                })
            };
            assert!(bytes(1) == bytes(2), "{}, {settings:?}", path.display());
        }
    }
}

#[test]
fn batches_give_the_hits_of_single_rays_on_one_and_two_threads() {
    let (_, asset) = baked_asset(&source_scenes()[0]);
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    let frame = scene.commit();
    let oracle = Oracle::new(&frame, &[instance]);
    let rays: Vec<Ray> = Rays::new(&oracle, 11).take(3_000).collect();
    let single: Vec<Option<Hit>> = rays.iter().map(|ray| frame.closest_hit(ray)).collect();
    assert!(single.iter().flatten().count() > 500);
    for threads in [1, 2] {
        let mut hits = vec![None; rays.len()];
        on_threads(threads, || frame.closest_hits(&rays, &mut hits));
        assert!(hits == single, "{threads} threads");
        let mut occluded = vec![false; rays.len()];
        on_threads(threads, || frame.any_hits(&rays, &mut occluded));
        assert!(
            occluded.iter().zip(&single).all(|(any, hit)| *any == hit.is_some()),
            "{threads} threads"
        );
    }
}
