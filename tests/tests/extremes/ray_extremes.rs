//! Rays at the limits: origins and directions on which traversal decides by equality, components at the ends of the
//! range of `f32`, ranges of every kind, and rays that are none.

use restpose_bake::verify::Oracle;
use restpose_runtime::{Affine, Asset, Frame, Ray};
use restpose_tests::{
    Aim, AimedRays, MeshRecipe, ODD_COMPONENTS, Stage, assert_rays_equal, baked_animation, closed_surfaces,
    jointed_mesh,
};
use std::sync::Arc;

/// Closed surfaces that stand still, whose local space is world space, so that an origin is exactly on a plane; then
/// the same bent by joints.
fn assets() -> Vec<(String, Arc<Asset>)> {
    let mut assets = Vec::new();
    for (name, surface) in closed_surfaces() {
        for joints in [0, 4] {
            let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, joints)));
            assets.push((format!("{name} with {joints} joints"), asset));
        }
    }
    assets
}

#[test]
fn rays_on_planes_faces_vertices_and_edges_equal_brute_force() {
    const RAYS: usize = 9_000;
    let assets = assets();
    let mut split = 0;
    for (name, asset) in &assets {
        let mut stage = Stage::with(asset, Affine::IDENTITY, 3);
        let (frame, oracle, marks) = stage.commit();
        split += usize::from(marks.local.iter().any(|planes| !planes.splits.is_empty()));
        let hits = assert_rays_equal(name, &frame, &oracle, AimedRays::new(&marks, 11).take(RAYS));
        assert!(hits > RAYS / 6, "{name}: {hits} hits");
    }
    // A bent cube of twelve triangles is one leaf.
    assert!(
        split + 1 >= assets.len(),
        "{split} of {} have split planes",
        assets.len()
    );
}

/// What makes the test above sharp: where local space is world space, origins lie on the very planes.
#[test]
fn origins_lie_on_split_planes_bit_for_bit() {
    for (name, surface) in closed_surfaces() {
        let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, 0)));
        let mut stage = Stage::with(&asset, Affine::IDENTITY, 0);
        let (.., marks) = stage.commit();
        let mut rays = AimedRays::new(&marks, 12);
        for _ in 0..500 {
            let origin = rays.ray(Aim::SplitPlane).origin;
            let on = |(axis, split): &(usize, f32)| origin[*axis] == *split;
            assert!(
                marks.local.iter().flat_map(|planes| &planes.splits).any(on),
                "{name}: {origin:?}"
            );
            let face = rays.ray(Aim::BoxFace).origin;
            let on = |k: usize| {
                marks
                    .world_boxes
                    .iter()
                    .any(|b| face[k] == b.min[k] || face[k] == b.max[k])
            };
            assert!((0..3).any(on), "{name}: {face:?}");
        }
    }
}

/// Every triple of odd components as a direction, from outside, inside, a vertex and a corner of the box.
#[test]
fn every_triple_of_odd_direction_components_equals_brute_force() {
    for (name, asset) in assets()
        .into_iter()
        .filter(|(name, _)| name.contains("cube") || name.contains("tube"))
    {
        let mut stage = Stage::with(&asset, Affine::IDENTITY, 3);
        let (frame, oracle, marks) = stage.commit();
        let bounds = frame.bounds();
        let origins = [
            bounds.center(),
            marks.triangles[0][0],
            bounds.min,
            [0.0, 0.0, -1.0],
            [-0.0, 0.0, 0.0],
        ];
        let range = |ray| Ray {
            t_min: f32::NEG_INFINITY,
            ..ray
        };
        let mut rays = Vec::new();
        for x in ODD_COMPONENTS {
            for y in ODD_COMPONENTS {
                for z in ODD_COMPONENTS {
                    rays.extend(origins.map(|origin| range(Ray::new(origin, [x, y, z]))));
                }
            }
        }
        let hits = assert_rays_equal(&name, &frame, &oracle, rays.iter().copied());
        assert!(hits > rays.len() / 3, "{name}: {hits} hits of {}", rays.len());
    }
}

/// Zeros of either sign are one number: they give the same hit.
#[test]
fn the_sign_of_a_zero_changes_nothing() {
    for (name, asset) in assets() {
        let mut stage = Stage::with(&asset, Affine::IDENTITY, 3);
        let (frame, _, marks) = stage.commit();
        let mut rays = AimedRays::new(&marks, 13);
        for _ in 0..500 {
            let ray = rays.ray(Aim::Axis);
            // Adding zero makes +0 of both zeros.
            let plus = Ray {
                direction: ray.direction.map(|d| d + 0.0),
                origin: ray.origin.map(|x| x + 0.0),
                ..ray
            };
            let minus = Ray {
                direction: plus.direction.map(|d| if d == 0.0 { -0.0 } else { d }),
                ..plus
            };
            assert_eq!(frame.closest_hit(&plus), frame.closest_hit(&minus), "{name}: {plus:?}");
        }
    }
}

/// Ranges that begin or end at a hit's very `t`, one number before and one behind it, and ranges without an end.
#[test]
fn ranges_at_a_hit_equal_brute_force() {
    for (name, asset) in assets() {
        let mut stage = Stage::with(&asset, Affine::IDENTITY, 3);
        let (frame, oracle, marks) = stage.commit();
        let mut tried = 0;
        for ray in AimedRays::new(&marks, 14).take(600) {
            let ray = Ray {
                t_min: f32::NEG_INFINITY,
                t_max: f32::INFINITY,
                ..ray
            };
            let Some(hit) = oracle.closest_hit(&ray) else { continue };
            tried += 1;
            let t = hit.t;
            for (t_min, t_max, expected) in [
                (t, t, Some(hit)),
                (f32::NEG_INFINITY, t, Some(hit)),
                (t, f32::INFINITY, Some(hit)),
                (f32::NEG_INFINITY, t.next_down(), None),
                (t, t.next_down(), None),
                (t.next_up(), t, None),
                (f32::INFINITY, f32::NEG_INFINITY, None),
                (f32::NEG_INFINITY, f32::NEG_INFINITY, None),
                (f32::INFINITY, f32::INFINITY, None),
            ] {
                let ray = Ray { t_min, t_max, ..ray };
                assert_eq!(frame.closest_hit(&ray), expected, "{name}: {ray:?}");
                assert_eq!(frame.any_hit(&ray), expected.is_some(), "{name}: {ray:?}");
            }
            let behind = Ray {
                t_min: t.next_up(),
                ..ray
            };
            assert_rays_equal(&name, &frame, &oracle, [behind]);
        }
        assert!(tried > 200, "{name}: {tried}");
    }
}

fn assert_no_hit(frame: &Frame, oracle: &Oracle, ray: Ray) {
    assert_eq!(frame.closest_hit(&ray), None, "{ray:?}");
    assert!(!frame.any_hit(&ray), "{ray:?}");
    assert_eq!(oracle.closest_hit(&ray), None, "{ray:?}");
}

/// NaN and infinity in every place of a ray that would hit, reversed ranges, and no direction: no hit, and an end.
#[test]
fn rays_that_are_none_hit_nothing() {
    let (_, asset) = assets().swap_remove(0);
    let mut stage = Stage::with(&asset, Affine::IDENTITY, 0);
    let (frame, oracle, _) = stage.commit();
    let good = Ray::new([0.01, 0.02, -3.0], [0.0, 0.0, 1.0]);
    assert!(frame.closest_hit(&good).is_some());
    for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for k in 0..3 {
            let (mut origin, mut direction) = (good, good);
            origin.origin[k] = bad;
            direction.direction[k] = bad;
            assert_no_hit(&frame, &oracle, origin);
            assert_no_hit(&frame, &oracle, direction);
        }
    }
    for (t_min, t_max) in [
        (f32::NAN, 9.0),
        (0.0, f32::NAN),
        (f32::NAN, f32::NAN),
        (9.0, 0.0),
        (1.0, 1.0f32.next_down()),
        (f32::INFINITY, 0.0),
        (0.0, f32::NEG_INFINITY),
    ] {
        assert_no_hit(&frame, &oracle, Ray { t_min, t_max, ..good });
    }
    for direction in [[0.0; 3], [-0.0; 3], [0.0, -0.0, 0.0]] {
        assert_no_hit(&frame, &oracle, Ray { direction, ..good });
    }
}
