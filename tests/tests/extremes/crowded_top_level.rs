//! Top levels that no plane can split: one box, two and ten thousand identical ones.

use rayon::ThreadPoolBuilder;
use restpose_runtime::{Affine, Asset, Ray};
use restpose_samples::surface::Surface;
use restpose_tests::{AimedRays, MeshRecipe, Stage, assert_rays_equal, baked_animation, jointed_mesh};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// Far more than a frame of ten thousand identical boxes takes (tens of milliseconds when optimised), far less than
/// what is quadratic in them.
const LONGEST: Duration = Duration::from_secs(5);

fn triangle() -> Arc<Asset> {
    let mut surface = Surface::default();
    let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.25], [0.0, 0.5, -0.25]];
    let corners = corners.map(|p| surface.push(p.into()));
    surface.triangles.push(corners);
    baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, 0)))
}

fn crowd(count: usize, transform: impl Fn(usize) -> Affine) -> Stage {
    let asset = triangle();
    let mut stage = Stage::default();
    for index in 0..count {
        stage.add(&asset, transform(index), 0);
    }
    stage
}

#[test]
fn identical_instances_give_the_first() {
    // Other tests keep the common threads busy.
    let alone = ThreadPoolBuilder::new().build().unwrap();
    for (count, rays) in [(1, 3_000), (2, 3_000), (10_000, 60)] {
        let mut stage = crowd(count, |_| Affine::IDENTITY);
        let start = Instant::now();
        alone.install(|| {
            stage.scene.commit();
        });
        assert!(start.elapsed() < LONGEST, "{count} boxes took {:?}", start.elapsed());
        let (frame, oracle, marks) = stage.commit();
        frame.prepare();
        assert_eq!(frame.stats().clusters as usize, count);
        let down = Ray::new([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        let hit = frame.closest_hit(&down).unwrap();
        assert_eq!((hit.instance.index(), hit.triangle), (0, 0));

        let start = Instant::now();
        let traced: Vec<Ray> = AimedRays::new(&marks, 71).take(rays).collect();
        assert!(
            traced
                .iter()
                .filter_map(|ray| frame.closest_hit(ray))
                .all(|hit| hit.instance.index() == 0)
        );
        assert!(start.elapsed() < LONGEST, "{rays} rays took {:?}", start.elapsed());
        let hits = assert_rays_equal(&format!("{count} instances"), &frame, &oracle, traced);
        assert!(hits > rays / 8, "{hits} hits of {rays}");
    }
}

/// Identical boxes around different triangles: each instance is turned half about the middle of its box, or is not.
#[test]
fn identical_boxes_around_different_triangles_equal_brute_force() {
    for (count, rays) in [(2, 3_000), (1_000, 300)] {
        let mut turned = Affine::IDENTITY;
        turned.columns[0][0] = -1.0;
        turned.columns[2][2] = -1.0;
        let mut stage = crowd(count, |index| if index % 2 == 0 { turned } else { Affine::IDENTITY });
        stage.assert_equals_brute_force(&format!("{count} instances"), rays, 72);
    }
}

/// Instances that differ by a bit, share a face, or have a box without volume, side by side.
#[test]
fn boxes_that_touch_equal_brute_force() {
    let shift = |x: f32| Affine::from_translation([x, 0.0, 0.0]);
    let flat = |x: f32| {
        let mut transform = shift(x);
        transform.columns[2] = [0.0; 3];
        transform.columns[0][2] = 0.0;
        transform
    };
    let all: [(&str, &dyn Fn(usize) -> Affine); 3] = [
        ("a bit apart", &|index| {
            shift(f32::from_bits(1.0f32.to_bits() + index as u32))
        }),
        ("face to face", &|index| shift(index as f32)),
        ("flat", &|index| flat((index % 7) as f32)),
    ];
    for (name, transform) in all {
        let hits = crowd(200, transform).assert_equals_brute_force(name, 600, 73);
        assert!(hits > 60, "{name}: {hits} hits");
    }
}
