//! The contract in any pose: hits equal brute force, bit for bit, far outside of what a file was baked for.

use restpose_bake::{
    BakeSettings, MotionClass, NoProgress, bake,
    import::{Animation, ImportSettings, import, import_files},
    verify::{PoseFamily, PoseSource, VerifyReport, VerifySettings, verify},
};
use restpose_formats::Bounds;
use restpose_tests::{CacheRecipe, Motion, baked_with, kd_twin, random_cache, sample_scenes};

fn verified(animation: &Animation, settings: &BakeSettings, source: PoseSource, rays: u64, poses: u64) -> VerifyReport {
    let asset = baked_with(animation, settings);
    let settings = VerifySettings {
        rays,
        poses,
        pose_source: Some(source),
        seed: 6,
    };
    let report = verify(&asset, animation, &settings, &NoProgress).unwrap();
    let twin = verify(&kd_twin(&asset), animation, &settings, &NoProgress).unwrap();
    assert_eq!(twin.hits, report.hits);
    if asset.model().meta.bounds == Bounds::Envelope {
        assert_equals_brute_force("kd-trees", &twin);
    }
    report
}

#[track_caller]
fn assert_equals_brute_force(name: &str, report: &VerifyReport) {
    let found = (report.missed, report.wrong);
    assert_eq!(found, (0, 0), "{name}: {:#?}\n{:#?}", report.families, report.failures);
    assert!(
        report.hits > report.rays / 10,
        "{name}: {} of {} hit",
        report.hits,
        report.rays
    );
}

/// Vertex caches whose bone is turned, stretched, flattened and moved away: no bone blends with another, so there is no
/// pose to leave.
#[test]
fn vertex_caches_equal_brute_force() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    let inputs = ["goose.obj", "goose.pc2"].map(|name| folder.join(name));
    let goose = import_files(&inputs, &ImportSettings::default()).unwrap().animation;
    // The stage does not move, and cannot be asked to.
    let moving = goose.parts.iter().filter(|part| part.name != "stage");
    for class in [MotionClass::Keyframed, MotionClass::Free] {
        let settings = BakeSettings {
            class_overrides: moving.clone().map(|part| (part.name.clone(), class)).collect(),
            rays_per_frame: 0.0,
            ..BakeSettings::default()
        };
        let report = verified(&goose, &settings, PoseSource::Random, 4_000, 40);
        assert_equals_brute_force(&format!("goose, {class:?}"), &report);
    }
}

#[test]
fn random_vertex_caches_equal_brute_force() {
    for seed in 0..24 {
        let recipe = CacheRecipe {
            seed,
            frames: 4,
            parts: 2,
            pieces: 3,
            points: 8,
            bridges: 2,
            motions: Motion::ALL,
            residual: 0.05,
            offset: if seed % 2 == 0 { 0.0 } else { 10.0 },
            moving_nodes: seed % 4 < 2,
            scale: 10f64.powi(seed as i32 % 5 - 2),
        };
        let settings = BakeSettings {
            rays_per_frame: 0.0,
            ..BakeSettings::default()
        };
        let report = verified(&random_cache(&recipe), &settings, PoseSource::Random, 1_200, 40);
        assert_eq!(
            (report.missed, report.wrong),
            (0, 0),
            "{recipe:?}: {:#?}",
            report.failures
        );
    }
}

/// A part whose triangles each follow one bone has tight boxes that hold wherever that bone is.
#[test]
fn rigid_parts_equal_brute_force() {
    let mut found = 0;
    for path in sample_scenes() {
        let mut animation = import(&path).unwrap().animation;
        let settings = BakeSettings::default();
        let classes = bake(&animation, &settings, &NoProgress).unwrap().report.parts;
        let rigid = |class| matches!(class, MotionClass::Static | MotionClass::Rigid);
        let mut classes = classes.iter().map(|part| rigid(part.class));
        animation.parts.retain(|_| classes.next() == Some(true));
        if animation.parts.is_empty() {
            continue;
        }
        found += 1;
        let report = verified(&animation, &settings, PoseSource::Random, 11_000, 110);
        assert_equals_brute_force(&path.display().to_string(), &report);
    }
    assert!(found > 0, "a bundled sample has rigid parts");
}

/// Skins, with envelopes of their clips: every family of poses, each a way to leave them.
#[test]
fn skins_equal_brute_force() {
    let mut families = Vec::new();
    for path in sample_scenes() {
        let animation = import(&path).unwrap().animation;
        let settings = BakeSettings {
            bounds: Bounds::Envelope,
            ..BakeSettings::default()
        };
        let report = verified(&animation, &settings, PoseSource::Random, 22_000, 110);
        let name = path.display().to_string();
        assert_equals_brute_force(&name, &report);
        families.extend(report.families.iter().map(|found| (name.clone(), found.clone())));
    }
    // A mesh of bones that blend leaves its envelopes in all families but those that may change nothing of it.
    for family in PoseFamily::ALL {
        let outside = families
            .iter()
            .filter(|(_, found)| found.family == family)
            .any(|(_, found)| found.clusters_outside > 0 && found.largest_excess > 0.0);
        assert!(outside, "{family:?}: {families:#?}");
    }
}

/// Boxes around samples lose hits in other poses, and a verification says so: were it blind, all else here would be, too.
#[test]
fn sampled_boxes_miss_hits_in_random_poses_and_are_caught() {
    let path = sample_scenes()
        .into_iter()
        .find(|path| path.ends_with("walker.glb"))
        .unwrap();
    let animation = import(&path).unwrap().animation;
    let settings = BakeSettings {
        bounds: Bounds::Sampled,
        ..BakeSettings::default()
    };
    let report = verified(&animation, &settings, PoseSource::Random, 11_000, 110);
    assert!(report.missed > 0, "{report:#?}");
    let of_families =
        |number: fn(&restpose_bake::verify::FamilyReport) -> u64| -> u64 { report.families.iter().map(number).sum() };
    assert_eq!(of_families(|family| family.missed), report.missed);
    assert_eq!(of_families(|family| family.rays), report.rays);
    assert_eq!(of_families(|family| family.poses), report.poses);
    // Such a file does not know which poses are outside.
    assert_eq!(of_families(|family| family.clusters_outside), 0);
    assert!(
        report
            .failures
            .iter()
            .all(|failure| failure.family.is_some() && failure.sample.is_none())
    );
}
