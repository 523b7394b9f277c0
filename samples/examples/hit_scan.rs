//! Hit-scan: what does a shot hit, on which bone, and where does the mark go that it leaves?
//!
//! A figure walks past a marksman, who fires twelve shots. Each hit is named by part, node, triangle of the source and bone,
//! and leaves a mark at a point of the rest pose. At the end the skin has carried the marks along. Fails if a mark was not
//! made where its shot ends.
//!
//! `cargo run --release -p restpose-samples --example hit_scan`
#![expect(clippy::print_stdout, reason = "a program for people")]

use glam::Vec3;
use restpose_bake::{BakeSettings, NoProgress, bake, import::import};
use restpose_runtime::{Affine, Asset, Frame, Hit, InstanceId, Ray, Scene, SurfacePoint};
use std::{error::Error, path::Path, sync::Arc};

const SHOTS: u32 = 12;
const SECONDS_PER_SHOT: f32 = 0.15;
/// As fast as the feet of the clip move over the ground, metres per second.
const SPEED: f32 = 0.883;
const MARKSMAN: Vec3 = Vec3::new(8.0, 1.5, 0.5);
/// Both ways of a mark's point are sums of a few `f32` numbers below ten, so they agree to a few micrometres; a tenth of a
/// millimetre is still less than anyone sees of a mark.
const MARK_METRES: f32 = 1e-4;

struct Shot {
    seconds: f32,
    ray: Ray,
    hit: Option<(Hit, SurfacePoint)>,
}

fn baked_walker() -> Result<Arc<Asset>, Box<dyn Error>> {
    // A game ships the baked file and calls Asset::open; here it is baked first.
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker.glb");
    let baked = bake(&import(&source)?.animation, &BakeSettings::default(), &NoProgress)?;
    Ok(Arc::new(Asset::from_bytes(&restpose_formats::write(&baked.model)?)?))
}

/// Where the figure is at a moment; it looks and walks along z.
fn walk(scene: &mut Scene, figure: InstanceId, clip: usize, seconds: f32) -> Result<(), Box<dyn Error>> {
    scene.set_transform(figure, Affine::from_translation([0.0, 0.0, seconds * SPEED]))?;
    // The clip is one cycle of a second.
    scene.play(figure, clip, seconds.fract())?;
    Ok(())
}

/// The middle of the figure, more or less, as a marksman with an unsteady hand aims at it.
fn aim(seconds: f32, hand: &mut fastrand::Rng) -> Ray {
    let target = Vec3::new(0.0, 0.1 + 1.6 * hand.f32(), seconds * SPEED + 0.4 * (hand.f32() - 0.5));
    // At length one, so that t counts in metres.
    Ray::new(MARKSMAN.to_array(), (target - MARKSMAN).normalize().to_array())
}

fn volley(scene: &mut Scene, figure: InstanceId, clip: usize) -> Result<Vec<Shot>, Box<dyn Error>> {
    let mut hand = fastrand::Rng::with_seed(6);
    let mut shots = Vec::new();
    for shot in 0..SHOTS {
        let seconds = shot as f32 * SECONDS_PER_SHOT;
        walk(scene, figure, clip, seconds)?;
        let frame = scene.commit();
        let ray = aim(seconds, &mut hand);
        let hit = match frame.closest_hit(&ray) {
            Some(hit) => {
                check_mark(&frame, &ray, &hit)?;
                Some((hit, frame.surface(&hit)?))
            }
            None => None,
        };
        shots.push(Shot { seconds, ray, hit });
    }
    Ok(shots)
}

/// Where a mark on a triangle is in this frame: in world space, on whatever place of the skin it was made.
fn mark(frame: &Frame, hit: &Hit) -> Option<Vec3> {
    let [a, b, c] = frame.triangle(hit.instance, hit.triangle)?.map(Vec3::from);
    Some((1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c)
}

fn end_of(ray: &Ray, hit: &Hit) -> Vec3 {
    Vec3::from(ray.origin) + hit.t * Vec3::from(ray.direction)
}

fn check_mark(frame: &Frame, ray: &Ray, hit: &Hit) -> Result<(), Box<dyn Error>> {
    let end = end_of(ray, hit);
    let mark = mark(frame, hit).ok_or("the triangle that was hit is in the frame")?;
    if mark.distance(end) > MARK_METRES {
        return Err(format!("the shot ends at {end}, its mark is at {mark}").into());
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let asset = baked_walker()?;
    let clip = asset.clip("walk").ok_or("the walker walks")?;
    let mut scene = Scene::new();
    let figure = scene.add(&asset);
    let shots = volley(&mut scene, figure, clip)?;

    let names = &asset.model().meta;
    for shot in &shots {
        let Some((hit, surface)) = &shot.hit else {
            println!("{:.2} s: missed", shot.seconds);
            continue;
        };
        println!(
            "{:.2} s: bone {}, {:.3} m away at {:.3}, triangle {} of {} (node {}), mark at {:.3} in the rest pose",
            shot.seconds,
            names.bone_names[surface.bone as usize],
            hit.t,
            end_of(&shot.ray, hit),
            surface.source_triangle,
            names.part_names[surface.part as usize],
            surface.source_node,
            Vec3::from(surface.position_rest),
        );
    }

    let end = SHOTS as f32 * SECONDS_PER_SHOT;
    walk(&mut scene, figure, clip, end)?;
    let frame = scene.commit();
    println!("at {end:.2} s the skin has carried the marks along:");
    for shot in &shots {
        if let Some((hit, surface)) = &shot.hit {
            let now = mark(&frame, hit).ok_or("the triangle that was hit is in the frame")?;
            let moved = now.distance(Vec3::from(surface.position_world));
            println!(
                "  the mark of {:.2} s is at {now:.3}, {moved:.3} m from where it was made",
                shot.seconds
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_runtime::triangle::PreparedRay;

    #[test]
    fn shots_hit_what_testing_every_triangle_hits() {
        let asset = baked_walker().expect("the walker is baked");
        let clip = asset.clip("walk").expect("the walker walks");
        let mut scene = Scene::new();
        let figure = scene.add(&asset);
        let shots = volley(&mut scene, figure, clip).expect("each mark is where its shot ends");
        let hits = shots.iter().filter(|shot| shot.hit.is_some()).count();
        assert!(
            (6..SHOTS as usize).contains(&hits),
            "{hits} hits: the volley shows little"
        );
        for shot in &shots {
            walk(&mut scene, figure, clip, shot.seconds).expect("the figure walks");
            let frame = scene.commit();
            let ray = PreparedRay::new(&shot.ray).expect("the ray can hit");
            let rows = 0..asset.model().triangles.len() as u32;
            let tested = rows.filter_map(|row| {
                let corners = frame.triangle(figure, row).expect("the row is in the asset");
                Some((ray.intersect(&corners)?.t, row))
            });
            let nearest = tested.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(shot.hit.map(|(hit, _)| (hit.t, hit.triangle)), nearest);
        }
    }
}
