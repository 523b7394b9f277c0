//! Geometry that changes from frame to frame, in number too: a fountain of tumbling splinters around a walking figure, and
//! who can see whom through it.
//!
//! `cargo run --release -p restpose-samples --example supplied_geometry`
#![expect(clippy::print_stdout, reason = "a program for people")]

use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Asset, Ray, Scene};
use std::{error::Error, path::Path, sync::Arc};

const TICK: f32 = 1.0 / 30.0;

struct Splinter {
    position: [f32; 3],
    velocity: [f32; 3],
    spin: f32,
    age: f32,
}

impl Splinter {
    fn thrown(number: u32) -> Self {
        // Any angle will do, as long as none comes twice soon: steps of the golden angle.
        let angle = number as f32 * 2.399_963;
        Self {
            position: [0.0, 0.0, 0.6],
            velocity: [angle.cos() * 0.7, 4.0, angle.sin() * 0.7],
            spin: angle,
            age: 0.0,
        }
    }

    fn fall(&mut self) {
        self.velocity[1] -= 9.81 * TICK;
        for k in 0..3 {
            self.position[k] += self.velocity[k] * TICK;
        }
        self.spin += 9.0 * TICK;
        self.age += TICK;
    }

    fn corners(&self) -> [[f32; 3]; 3] {
        [0.0f32, 2.1, 4.2].map(|turn| {
            let (sine, cosine) = (self.spin + turn).sin_cos();
            let [x, y, z] = self.position;
            [x + 0.05 * cosine, y + 0.05 * sine, z + 0.02 * cosine]
        })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
    let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
    let asset = Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?);
    let walk = asset.clip("walk").ok_or("the walker walks")?;

    let mut scene = Scene::new();
    let walker = scene.add(&asset);
    let fountain = scene.add_geometry();
    let mut splinters: Vec<Splinter> = Vec::new();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for tick in 0..45u32 {
        splinters.extend((0..150).map(|i| Splinter::thrown(tick * 150 + i)));
        splinters.iter_mut().for_each(Splinter::fall);
        splinters.retain(|splinter| splinter.age < 1.0);
        positions.clear();
        triangles.clear();
        for splinter in &splinters {
            let first = positions.len() as u32;
            positions.extend(splinter.corners());
            triangles.push([first, first + 1, first + 2]);
        }
        scene.set_geometry(fountain, &positions, &triangles)?;
        scene.play(walker, walk, tick as f32 * TICK)?;
        let frame = scene.commit();

        if tick % 9 == 8 {
            let rays = (0..400).map(|i| {
                let (x, y) = ((i % 20) as f32 * 0.05 - 0.5, (i / 20) as f32 * 0.1);
                Ray::new([x, y, 10.0], [0.0, 0.0, -1.0])
            });
            let hits: Vec<_> = rays.filter_map(|ray| frame.closest_hit(&ray)).collect();
            let splinter_hits = hits.iter().filter(|hit| hit.instance == fountain).count();
            println!(
                "tick {tick:2}: {} splinters; of 400 views {splinter_hits} end at a splinter, {} at the walker",
                splinters.len(),
                hits.len() - splinter_hits,
            );
        }
    }
    Ok(())
}
