//! The contract for vertex caches: hits equal brute force, bit for bit, at any time between keys.

use proptest::{prelude::*, test_runner::RngSeed};
use restpose_bake::{
    BakeError, BakeSettings, Baked, DecomposeSettings, MotionClass, NoProgress, bake,
    import::{Animation, ImportSettings, import_files},
    verify::{VerifyReport, VerifySettings, verify},
};
use restpose_formats::TreeKind;
use restpose_runtime::Asset;
use restpose_tests::{CacheRecipe, Motion, kd_twin, random_cache};
use std::sync::Arc;

fn verified(animation: &Animation, settings: &BakeSettings, rays: u64) -> Option<(Baked, VerifyReport)> {
    let baked = match bake(animation, settings, &NoProgress) {
        // Far from the origin all points can be one, and a part that stands still cannot be in free motion.
        Err(BakeError::NothingToTrace | BakeError::Class { .. }) => return None,
        baked => baked.unwrap_or_else(|error| panic!("{error}")),
    };
    let bytes = restpose_formats::write(&baked.model).unwrap_or_else(|error| panic!("{error}"));
    let asset = Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")));
    let settings = VerifySettings {
        rays,
        poses: 12,
        pose_source: None,
        seed: 3,
    };
    let report = verify(&asset, animation, &settings, &NoProgress).unwrap_or_else(|error| panic!("{error}"));
    if baked.model.meta.tree == TreeKind::Kd {
        return Some((baked, report));
    }
    let twin = verify(&kd_twin(&asset), animation, &settings, &NoProgress).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (twin.missed, twin.wrong, twin.hits),
        (0, 0, report.hits),
        "kd-trees: {:#?}",
        twin.failures
    );
    Some((baked, report))
}

proptest! {
    // The same cases every time; PROPTEST_CASES=100000 is a night's search.
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(2), failure_persistence: None, ..ProptestConfig::with_cases(160) })]

    #[test]
    fn hits_equal_brute_force_on_random_caches(
        seed in any::<u64>(),
        frames in prop_oneof![Just(1usize), Just(2), Just(3), 4usize..40],
        parts in 1usize..3,
        pieces in 1usize..5,
        points in 3usize..14,
        bridges in 0usize..6,
        motion in 0usize..=Motion::ALL.len(),
        residual in prop_oneof![Just(0.0), Just(0.01), Just(0.3)],
        exponent in -30i32..=28,
        offset in prop_oneof![Just(0.0), Just(10.0), Just(1e4), Just(1e7)],
        moving_nodes in any::<bool>(),
        exact in any::<bool>(),
        segments in 1usize..5,
        size_worth in prop_oneof![Just(0.0), Just(0.1), Just(0.5)],
        free in prop_oneof![4 => Just(false), 1 => Just(true)],
    ) {
        let motions = if motion == Motion::ALL.len() { Motion::ALL } else { &Motion::ALL[motion..=motion] };
        let exponent = if offset > 10.0 { exponent / 2 } else { exponent };
        let recipe = CacheRecipe {
            seed, frames, parts, pieces, points, bridges, motions, residual, offset, moving_nodes,
            scale: 10f64.powi(exponent),
        };
        let animation = random_cache(&recipe);
        let overrides = if free {
            animation.parts.iter().map(|part| (part.name.clone(), MotionClass::Free)).collect()
        } else {
            Vec::new()
        };
        let settings = BakeSettings {
            position_error: exact.then_some(0.0),
            segments,
            size_worth,
            motion: DecomposeSettings { max_clusters: 6, ..DecomposeSettings::default() },
            rays_per_frame: 0.0,
            class_overrides: overrides,
            ..BakeSettings::default()
        };
        let Some((_, report)) = verified(&animation, &settings, 600) else {
            return Ok(());
        };
        prop_assert_eq!((report.missed, report.wrong), (0, 0), "{:?}: {:#?}", recipe, report.failures);
    }
}

/// Positions are rounded to 2⁻¹⁶ of the part's greatest diagonal, which can be twice that of another key's pose, and
/// evaluated in `f32`.
const VERTEX_TOLERANCE: f64 = 4e-5;

/// The bundled vertex cache, whole and in time segments: hits equal brute force, and vertices are where the source has
/// them in every pose, so none is left over from the pose before.
#[test]
fn hits_equal_brute_force_on_the_sample() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    let inputs = ["goose.obj", "goose.pc2"].map(|name| folder.join(name));
    let animation = import_files(&inputs, &ImportSettings::default()).unwrap().animation;
    // Where boxes are at keys, to split saves nothing.
    for (segments, tree) in [(1, TreeKind::Wide), (3, TreeKind::Kd)] {
        let settings = BakeSettings {
            segments,
            tree,
            size_worth: 0.0,
            motion: DecomposeSettings {
                max_clusters: 12,
                ..DecomposeSettings::default()
            },
            rays_per_frame: 0.0,
            ..BakeSettings::default()
        };
        let (baked, report) = verified(&animation, &settings, 6_000).unwrap();
        let found = baked.report.parts[0].cache.as_ref().unwrap().segments.len();
        assert_eq!(found, segments, "the goose's parts are cut in time where asked for");
        assert_eq!((report.missed, report.wrong), (0, 0), "{:#?}", report.failures);
        assert!(
            report.max_vertex_error < VERTEX_TOLERANCE,
            "{}",
            report.max_vertex_error
        );
    }
}
