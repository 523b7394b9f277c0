//! Poses inside and outside of what a file was baked for.

use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_formats::Bounds;
use restpose_runtime::{Asset, Scene};
use restpose_tests::source_scenes;
use std::{path::Path, sync::Arc};

fn enveloped(path: &Path, envelopes: usize) -> Arc<Asset> {
    let settings = BakeSettings {
        bounds: Bounds::Envelope,
        envelopes,
        ..BakeSettings::default()
    };
    let baked = bake(&import(path).unwrap().animation, &settings, &NoProgress).unwrap();
    Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model).unwrap()).unwrap())
}

/// The continuous motion of every clip is inside its pose space, at times that no sample knows.
#[test]
fn clips_never_leave_their_pose_space() {
    for path in source_scenes() {
        for envelopes in [1, 5, 16] {
            let asset = enveloped(&path, envelopes);
            let model = asset.model();
            let mut random = fastrand::Rng::with_seed(3);
            let mut scene = Scene::new();
            let instance = scene.add(&asset);
            for clip in 0..model.clips.len() {
                let row = model.clips[clip];
                for _ in 0..300 {
                    let seconds = row.start_seconds + random.f32() * (row.end_seconds - row.start_seconds);
                    scene.play(instance, clip, seconds).unwrap();
                    let frame = scene.commit();
                    assert_eq!(
                        frame.stats().clusters_outside,
                        0,
                        "{} in {envelopes} envelopes: clip {clip} at {seconds} s: {:?}",
                        path.display(),
                        frame.stats()
                    );
                    assert!(scene.commit_inside().is_ok());
                }
            }
        }
    }
}
