//! Hit-scan: which bone does a shot hit, and where on the body?
//!
//! `cargo run --release -p restpose-samples --example hit_scan`
#![expect(clippy::print_stdout, reason = "a program for people")]

use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc};

fn main() -> Result<(), Box<dyn Error>> {
    // A game ships the baked file and calls Asset::open; here it is baked first.
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
    let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
    let walk = asset.clip("walk").ok_or("the walker walks")?;

    // Two characters share one asset; each has its own place and moment.
    let mut scene = Scene::new();
    let near = scene.add(&asset);
    let far = scene.add(&asset);
    scene.set_transform(far, Affine::from_translation([0.5, 0.0, -2.0]))?;
    scene.play(near, walk, 0.1)?;
    scene.play(far, walk, 0.6)?;
    let frame = scene.commit();

    for (x, height) in [(0.1, 0.2), (0.1, 0.6), (0.0, 1.0), (0.5, 1.3), (0.5, 1.6), (0.0, 2.5)] {
        let shot = Ray::new([x, height, 10.0], [0.0, 0.0, -1.0]);
        match frame.closest_hit(&shot) {
            Some(hit) => {
                let surface = frame.surface(&hit)?;
                println!(
                    "at {height} m: character {}, bone {}, {:.3} m away, triangle {} of mesh {}, decal at {:?} in the rest pose",
                    hit.instance.index(),
                    asset.model().meta.bone_names[surface.bone as usize],
                    hit.t,
                    surface.source_triangle,
                    surface.source_mesh,
                    surface.position_rest,
                );
            }
            None => println!("at {height} m: nothing"),
        }
    }

    // Line of sight only asks whether anything is in between.
    let (eye, target) = ([0.0, 1.5, 10.0], [0.0, 1.0, -10.0]);
    println!(
        "line of sight: {}",
        if frame.any_hit(&Ray::between(eye, target)) {
            "blocked"
        } else {
            "free"
        }
    );
    Ok(())
}
