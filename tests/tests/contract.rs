//! The contract: hits equal brute force, bit for bit, in every pose that a file was baked for.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::import,
    verify::{VerifySettings, verify},
};
use restpose_runtime::Asset;
use restpose_tests::source_scenes;
use std::sync::Arc;

/// Vertices are evaluated in `f64` and rounded to `f32` a few times; eight chained roundings of numbers a few times the
/// model's size stay under this.
const VERTEX_TOLERANCE: f64 = 2e-6;

#[test]
fn hits_equal_brute_force_on_every_scene() {
    let scenes = source_scenes();
    assert!(!scenes.is_empty(), "the bundled samples are part of the repository");
    for path in scenes {
        let animation = import(&path).unwrap().animation;
        let baked = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap();
        let bytes = restpose_formats::write(&baked.model).unwrap();
        let asset = Arc::new(Asset::from_bytes(&bytes).unwrap());
        let settings = VerifySettings {
            rays: 20_000,
            poses: 24,
            seed: 7,
        };
        let report = verify(&asset, &animation, &settings, &NoProgress).unwrap();
        println!("{}: {report:?}", path.display());
        assert_eq!(
            (report.missed, report.wrong),
            (0, 0),
            "{}: {:#?}",
            path.display(),
            report.failures
        );
        assert!(
            report.hits > report.rays / 5,
            "{}: {} of {} rays hit",
            path.display(),
            report.hits,
            report.rays
        );
        assert!(
            report.max_vertex_error < VERTEX_TOLERANCE,
            "{}: {}",
            path.display(),
            report.max_vertex_error
        );
    }
}
