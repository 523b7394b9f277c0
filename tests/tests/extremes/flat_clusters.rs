//! Clusters without a volume: thin ones, flat ones, lines, single points, and triangles that are all the same.

use restpose_bake::{BakeError, BakeSettings, NoProgress, bake, import::Animation};
use restpose_runtime::{Affine, Asset};
use restpose_samples::surface::Surface;
use restpose_tests::{MeshRecipe, Stage, baked_animation, cached_mesh, jointed_mesh, tube};
use std::sync::Arc;

const RAYS: usize = 1_200;

/// Directions in which a tube is pressed, and to which part of its size.
const THICKNESSES: [f64; 6] = [1e-3, 1e-7, 1e-12, 1e-30, 1e-44, 0.0];

fn pressed(axes: &[usize], thickness: f64) -> Surface {
    tube().map(|p| {
        let mut p = p.to_array();
        axes.iter().for_each(|k| p[*k] *= thickness);
        p.into()
    })
}

/// The asset, or `None` where no triangle has an area.
fn asset(animation: &Animation) -> Option<Arc<Asset>> {
    match bake(animation, &BakeSettings::default(), &NoProgress) {
        Err(BakeError::NothingToTrace) => None,
        _ => Some(baked_animation(animation)),
    }
}

/// A turn by no round angle, so that what is flat lies across all axes.
fn turned() -> Affine {
    let mut out = Affine::from_translation([0.1, -0.3, 0.2]);
    out.columns[0] = [0.36, 0.48, -0.8];
    out.columns[1] = [-0.8, 0.6, 0.0];
    out.columns[2] = [0.48, 0.64, 0.6];
    out
}

#[test]
fn pressed_meshes_equal_brute_force() {
    let (mut baked, mut hits) = (0, 0);
    for axes in [&[2][..], &[0, 2], &[0, 1], &[0, 1, 2]] {
        for thickness in THICKNESSES {
            let surface = pressed(axes, thickness);
            for (joints, stiff) in [(0, false), (3, true), (3, false)] {
                let recipe = MeshRecipe {
                    stiff,
                    ..MeshRecipe::new(&surface, joints)
                };
                let Some(asset) = asset(&jointed_mesh(&recipe)) else {
                    assert!(
                        thickness < 1e-20 && axes.len() > 1,
                        "{axes:?} by {thickness} has an area"
                    );
                    continue;
                };
                baked += 1;
                for transform in [Affine::IDENTITY, turned()] {
                    let name = format!("axes {axes:?} by {thickness}, {joints} joints");
                    hits += Stage::with(&asset, transform, 3).assert_equals_brute_force(&name, RAYS / 4, 51);
                }
            }
        }
    }
    assert!(baked > 36 && hits > baked * RAYS / 20, "{baked} baked, {hits} hits");
}

/// The same by a vertex cache, whose fits see a plane, a line or a point: pressed in every frame, or less and less.
#[test]
fn pressed_vertex_caches_equal_brute_force() {
    let tube = tube();
    let (mut baked, mut hits) = (0, 0);
    for axes in [&[2][..], &[0, 2], &[0, 1, 2]] {
        for last in [0.0, 1e-12, 1.0] {
            for first in [0.0, 1e-30, 1e-7] {
                let frame = |frame: u32| -> Vec<[f32; 3]> {
                    let share = f64::from(frame) / 4.0;
                    let surface = pressed(axes, first + share * (last - first));
                    let place = |p: [f64; 3]| [p[0] + share * p[1], p[1] - share * p[2], p[2] + 0.3 * share];
                    let points = surface.positions.iter();
                    points.map(|p| place(p.to_array()).map(|x| x as f32)).collect()
                };
                let animation = cached_mesh(&tube.triangles, &(0..5).map(frame).collect::<Vec<_>>());
                let Some(asset) = asset(&animation) else { continue };
                baked += 1;
                for time in [0.0, 0.25, 2.0, 3.7, 4.0] {
                    let mut stage = Stage::default();
                    let instance = stage.add(&asset, turned(), 0);
                    stage.scene.set_cache_frames(instance, &[time]).unwrap();
                    let name = format!("axes {axes:?} from {first} to {last} at {time}");
                    hits += stage.assert_equals_brute_force(&name, RAYS / 8, 52);
                }
            }
        }
    }
    assert!(baked > 18 && hits > baked * RAYS / 20, "{baked} baked, {hits} hits");
}

/// Every triangle is there many times, some turned round: the lowest is hit.
#[test]
fn triangles_in_the_same_place_equal_brute_force() {
    for count in [2u32, 9, 300] {
        for joints in [0, 2] {
            let mut surface = Surface::default();
            for copy in 0..count {
                let corners = [[0.0, -0.5, 0.0], [0.5, 0.5, 0.1], [-0.5, 0.5, -0.2]];
                let [a, b, c] = corners.map(|p| surface.push(p.into()));
                surface
                    .triangles
                    .push(if copy % 3 == 1 { [a, c, b] } else { [a, b, c] });
            }
            let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, joints)));
            let mut stage = Stage::with(&asset, turned(), 2);
            let name = format!("{count} triangles, {joints} joints");
            assert!(stage.assert_equals_brute_force(&name, RAYS, 53) > RAYS / 10, "{name}");
            let (frame, oracle, _) = stage.commit();
            let rays: Vec<_> = restpose_bake::verify::Rays::new(&oracle, 54).take(RAYS).collect();
            let hits = rays.iter().filter_map(|ray| frame.closest_hit(ray));
            // A turned copy sums its weights in another order, and may be nearer by a bit.
            assert!(hits.clone().all(|hit| hit.triangle < 2), "{name}");
            assert!(hits.count() > RAYS / 20, "{name}");
        }
    }
}

/// Triangles on one line have no area as they rest, and get one when a joint bends the line.
#[test]
fn lines_that_open_equal_brute_force() {
    for slope in [0.0, 1e-8, 1e-3] {
        let mut surface = Surface::default();
        for step in 0..=24u32 {
            let y = f64::from(step) / 24.0 - 0.5;
            surface.push([slope * f64::from(step % 2), y, 0.0].into());
        }
        for step in 0..=16u32 {
            surface.triangles.push([step, step + 8, (step * 5 + 3) % 25]);
        }
        for joints in [1, 3] {
            let Some(asset) = asset(&jointed_mesh(&MeshRecipe::new(&surface, joints))) else {
                assert!(slope == 0.0 && joints == 1);
                continue;
            };
            for sample in 0..6 {
                let name = format!("slope {slope}, {joints} joints, sample {sample}");
                Stage::with(&asset, turned(), sample).assert_equals_brute_force(&name, RAYS, 55);
            }
        }
    }
}
