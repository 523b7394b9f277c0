//! Animation without bones: bake a mesh and its vertex cache, play it at any moment, and between keys.
//!
//! `cargo run --release -p restpose-samples --example vertex_cache`
#![expect(clippy::print_stdout, reason = "a program for people")]

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{ImportSettings, import_files},
};
use restpose_runtime::{Asset, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc};

fn main() -> Result<(), Box<dyn Error>> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files = [scenes.join("goose.obj"), scenes.join("goose.pc2")];
    let source = import_files(&files, &ImportSettings::default())?.animation;
    let baked = bake(&source, &BakeSettings::default(), &NoProgress)?;
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);

    // The cache comes with a clip that plays its frames at the source's times.
    let mut scene = Scene::new();
    let goose = scene.add(&asset);
    let down = Ray::new([0.0, 10.0, 0.6], [0.0, -1.0, 0.0]);
    for seconds in [0.0, 1.0, 1.55] {
        scene.play(goose, 0, seconds)?;
        let frame = scene.commit();
        if let Some(hit) = frame.closest_hit(&down) {
            let part = asset
                .model()
                .parts
                .partition_point(|part| part.triangle_first <= hit.triangle)
                - 1;
            let name = &asset.model().meta.part_names[part];
            println!("at {seconds} s the ray from above meets the {name} after {:.4}", hit.t);
        }
    }

    // Frames can be set directly, too: one number per cache, keys from 0, any fraction between. In this file each moving
    // group of the OBJ file has a cache of its own, and they need not keep time.
    let caches = asset.model().caches.len();
    let mut frames = vec![20.0; caches];
    frames[0] = 20.5;
    scene.set_cache_frames(goose, &frames)?;
    println!("{caches} caches; bounds now {:?}", scene.commit().bounds());
    Ok(())
}
