//! A pose of the caller's own: take a clip's palette, turn the head's bone further, give it back.
//!
//! No clip turns the head that far. The frame's statistics say which clusters left their pose space, and hits are right all
//! the same (README, "What it guarantees").
//!
//! `cargo run --release -p restpose-samples --example external_palette`
#![expect(clippy::print_stdout, reason = "a program for people")]

use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc};

fn main() -> Result<(), Box<dyn Error>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
    let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
    let walk = asset.clip("walk").ok_or("the walker walks")?;
    let head = asset.bone("head").ok_or("the walker has a head")?;

    let mut scene = Scene::new();
    let walker = scene.add(&asset);
    scene.play(walker, walk, 0.3)?;
    let mut palette = scene.pose(walker)?.palette;

    // A palette entry maps rest space to asset space: world(joint) · inverse_bind. What is multiplied from the left
    // moves in asset space; here a turn of sixty degrees about the upright axis through the joint.
    let rest_from_joint = asset.model().bones[head].inverse_bind().columns[3].map(|x| -x);
    let pivot = palette[head].transform_point(rest_from_joint);
    let (sine, cosine) = (0.866_025_4, 0.5);
    let turn = Affine {
        columns: [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine], [0.0; 3]],
    };
    let back = Affine::from_translation(pivot.map(|x| -x));
    palette[head] = Affine::from_translation(pivot) * turn * back * palette[head];

    let nose = Ray::new([pivot[0], pivot[1] + 0.08, 10.0], [0.0, 0.0, -1.0]);
    let before = scene.commit().closest_hit(&nose);
    scene.set_palette(walker, &palette, &[])?;
    let frame = scene.commit();
    let after = frame.closest_hit(&nose);
    let stats = frame.stats();
    println!(
        "towards the face: {:?} before, {:?} after the turn",
        before.map(|hit| hit.t),
        after.map(|hit| hit.t)
    );
    println!(
        "{} of {} clusters are outside of their pose space, by {:.3} at most",
        stats.clusters_outside, stats.clusters, stats.largest_excess
    );
    Ok(())
}
