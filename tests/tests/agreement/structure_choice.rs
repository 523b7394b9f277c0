//! Fuzzy trees or a tree built in every frame: the baker's choice, by the rays of a frame, and the numbers that it gives.

use restpose_bake::{
    BakeError, BakeSettings, ExpectedFrame, MotionClass, NoProgress, bake,
    import::{Animation, FrameRange, ImportSettings, import_files},
};

fn animation(scene: &str, step: usize) -> Animation {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    let inputs = ["obj", "pc2"].map(|extension| folder.join(format!("{scene}.{extension}")));
    let settings = ImportSettings {
        frames: FrameRange {
            step,
            ..FrameRange::default()
        },
        ..ImportSettings::default()
    };
    import_files(&inputs, &settings).unwrap().animation
}

/// Bytes are worth so much that no boxes are stored for single keys.
const NO_KEY_BOXES: f64 = 1e9;

/// The class of the first part, and what its frame is expected to take.
fn choice(animation: &Animation, rays_per_frame: f64, size_worth: f64) -> (MotionClass, ExpectedFrame) {
    let settings = BakeSettings {
        rays_per_frame,
        size_worth,
        ..BakeSettings::default()
    };
    let report = bake(animation, &settings, &NoProgress).unwrap().report;
    let part = &report.parts[0];
    let expected = part.cache.as_ref().unwrap().expected_frame;
    assert_eq!(expected.rays, rays_per_frame);
    assert!(part.reason.ends_with(&expected.to_string()), "{}", part.reason);
    (part.class, expected)
}

/// With boxes at keys no more is expected of a frame than without, and few rays are the less a reason to build a tree.
#[test]
fn boxes_at_keys_are_expected_to_save_time_and_the_choice_agrees() {
    let size_worth = BakeSettings::default().size_worth;
    for (scene, step) in [("goose", 6), ("shatter", 3)] {
        let animation = animation(scene, step);
        for rays in [100.0, 1_000.0, 100_000.0, f64::MAX] {
            let (class, frame) = choice(&animation, rays, size_worth);
            let (_, without) = choice(&animation, rays, NO_KEY_BOXES);
            assert!(
                frame.fuzzy_ms <= without.fuzzy_ms,
                "{scene}: {frame}; without: {without}"
            );
            let free = class == MotionClass::Free;
            assert!(
                if free {
                    frame.rebuilt_ms <= frame.fuzzy_ms
                } else {
                    frame.fuzzy_ms <= frame.rebuilt_ms
                },
                "{frame}"
            );
            assert!(rays > 1_000.0 || !free, "{scene} at {rays} rays: {frame}");
        }
    }
}

/// A goose like jelly moves in one piece, a vase bursts into shards: by turns of thousands of rays and more.
#[test]
fn few_rays_keep_motion_keyframed_and_many_set_it_free() {
    for (scene, step, fewest, most) in [("goose", 6, 100.0, 1_000_000.0), ("shatter", 3, 50.0, 100_000.0)] {
        let animation = animation(scene, step);
        let mut evens = Vec::new();
        for (rays, expected) in [
            (0.0, MotionClass::Keyframed),
            (fewest, MotionClass::Keyframed),
            (most, MotionClass::Free),
            (f64::MAX, MotionClass::Free),
        ] {
            let (class, frame) = choice(&animation, rays, NO_KEY_BOXES);
            assert_eq!(class, expected, "{scene} at {rays} rays: {frame}");
            assert!(frame.fuzzy_ms.is_finite() && frame.rebuilt_ms.is_finite());
            let free = class == MotionClass::Free;
            // Both are the largest number for the largest number of rays.
            assert!(
                if free {
                    frame.rebuilt_ms <= frame.fuzzy_ms
                } else {
                    frame.fuzzy_ms < frame.rebuilt_ms
                },
                "{frame}"
            );
            let even = frame.even_rays.unwrap();
            assert_eq!(free, rays > even, "{frame}");
            evens.push(even);
        }
        assert!(
            evens.windows(2).all(|pair| pair[0] == pair[1]),
            "{evens:?} do not depend on the rays"
        );
    }
}

#[test]
fn rays_that_no_frame_has_are_refused() {
    let animation = animation("shatter", 9);
    for rays_per_frame in [f64::INFINITY, f64::NAN, -1.0] {
        let settings = BakeSettings {
            rays_per_frame,
            ..BakeSettings::default()
        };
        let refused = bake(&animation, &settings, &NoProgress);
        assert!(
            matches!(
                refused,
                Err(BakeError::Setting {
                    name: "rays per frame",
                    ..
                })
            ),
            "{rays_per_frame}"
        );
    }
}
