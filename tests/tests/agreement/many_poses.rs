//! The second proof obligation: ten million rays over ten thousand poses, in and out of the pose space, bit-equal to brute
//! force. `RESTPOSE_LONG=100 cargo test -p restpose-tests --test agreement many_poses` makes it a billion over a million.

use rayon::prelude::*;
use restpose_bake::{
    BakeSettings, LimitSettings, PoseSpace,
    verify::{Oracle, PoseSource, Poses, Rays},
};
use restpose_formats::{Bounds, TreeKind};
use restpose_runtime::{Affine, Posing, Scene};
use restpose_tests::{Recipe, baked_with, random_animation};

/// Soups, each with its bake and as many poses in its clips as far outside of them.
const SOUPS: u64 = 50;
const POSES: u64 = 200;
const RAYS: u64 = 1_000;

#[derive(Clone, Copy, Debug, Default)]
struct Found {
    rays: u64,
    hits: u64,
    poses_outside: u64,
    clusters: u64,
    without_inverse: u64,
}

#[test]
fn many_rays_in_many_poses_equal_brute_force() {
    let times = std::env::var("RESTPOSE_LONG").map_or(1, |times| times.parse().expect("a number of times"));
    let found: Vec<Found> = (0..SOUPS * times).into_par_iter().map(compare).collect();
    let sum = |number: fn(&Found) -> u64| found.iter().map(number).sum::<u64>();
    let rays = sum(|found| found.rays);
    assert_eq!(rays, SOUPS * times * POSES * RAYS);
    assert!(sum(|found| found.hits) > rays / 4, "{found:?}");
    // Of random poses most are outside; some change nothing of a soup, or take a bone's inverse away.
    let (poses, outside) = (rays / RAYS, sum(|found| found.poses_outside));
    assert!(outside > poses / 4, "{outside} of {poses}");
    let (clusters, without_inverse) = (sum(|found| found.clusters), sum(|found| found.without_inverse));
    assert!(without_inverse < clusters / 4, "{without_inverse} of {clusters}");
}

fn recipe(seed: u64) -> Recipe {
    let mut random = fastrand::Rng::with_seed(seed);
    Recipe {
        seed,
        vertices: random.usize(12..28),
        joints: random.usize(2..6),
        scale: 10f32.powi(random.i32(-6..=6)),
        offset: [0.0, 0.0, 1.0, 1e3][random.usize(..4)],
        wild_scales: seed.is_multiple_of(5),
        morph_targets: random.usize(..3),
    }
}

/// Panics at the first ray whose hit is not that of brute force.
fn compare(seed: u64) -> Found {
    let recipe = recipe(seed);
    let animation = random_animation(&recipe);
    let pose_space = match seed % 4 {
        0 => PoseSpace::Clips,
        1 => PoseSpace::Arbitrary,
        2 => PoseSpace::Limits(LimitSettings::default()),
        _ => PoseSpace::Clip("clip".to_owned()),
    };
    let asset = baked_with(
        &animation,
        &BakeSettings {
            bounds: Bounds::Envelope,
            pose_samples: pose_space.is_random().then_some(50),
            pose_space,
            envelopes: [1, 2, 16][seed as usize % 3],
            tree: TreeKind::ALL[seed as usize / 4 % 2],
            ..BakeSettings::default()
        },
    );
    let mut sources = [PoseSource::Clips, PoseSource::Random]
        .map(|source| Poses::new(&animation, asset.model(), source, seed, POSES / 2));
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    scene.set_posing(instance, Posing::Recomputed).unwrap();
    let mut found = Found::default();
    for index in 0..POSES {
        let of_clips = index % 2 == 0;
        let pose = sources[index as usize % 2].pose(index / 2);
        pose.set(&mut scene, instance).unwrap();
        scene
            .set_transform(instance, scaled(&pose.transform, recipe.scale))
            .unwrap();
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &[instance]);
        for ray in Rays::new(&oracle, pose.ray_seed).take(RAYS as usize) {
            let (expected, hit, any) = (oracle.closest_hit(&ray), frame.closest_hit(&ray), frame.any_hit(&ray));
            assert!(
                hit == expected && any == expected.is_some(),
                "{recipe:?}, {pose:?}, {ray:?}: {hit:?}, any {any}, by brute force {expected:?}"
            );
            found.hits += u64::from(hit.is_some());
        }
        frame.prepare();
        let stats = frame.stats();
        assert!(
            !of_clips || stats.clusters_outside == 0,
            "{recipe:?}, {pose:?}: {stats:?}"
        );
        found.rays += RAYS;
        found.poses_outside += u64::from(stats.clusters_outside > 0);
        found.clusters += u64::from(stats.clusters);
        found.without_inverse += u64::from(stats.clusters_without_inverse);
    }
    found
}

/// The transform with its translation, of a few units, in the soup's own unit.
fn scaled(transform: &Affine, unit: f32) -> Affine {
    let mut out = *transform;
    out.columns[3] = out.columns[3].map(|x| x * unit);
    out
}
