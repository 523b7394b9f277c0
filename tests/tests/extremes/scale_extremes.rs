//! Scenes at the ends of the range of `f32`: sixty powers of ten of scale, far from the origin, far from each other.

use restpose_runtime::Affine;
use restpose_tests::{
    MeshRecipe, Recipe, Stage, baked_animation, closed_surfaces, jointed_mesh, random_animation, tube,
};

const RAYS: usize = 1_500;

/// Powers of ten of scale, each 10⁵ from the next.
fn exponents() -> impl Iterator<Item = i32> {
    (-30..=30).step_by(5)
}

fn scaling(scale: f32) -> Affine {
    let mut transform = Affine::IDENTITY;
    for k in 0..3 {
        transform.columns[k][k] = scale;
    }
    transform
}

#[test]
fn meshes_baked_at_any_scale_equal_brute_force() {
    for exponent in exponents() {
        for (joints, stiff) in [(0, false), (4, false), (4, true)] {
            let animation = jointed_mesh(&MeshRecipe {
                stiff,
                scale: 10f64.powi(exponent),
                ..MeshRecipe::new(&tube(), joints)
            });
            let name = format!("1e{exponent}, {joints} joints");
            let hits = Stage::with(&baked_animation(&animation), Affine::IDENTITY, 3)
                .assert_equals_brute_force(&name, RAYS, 31);
            assert!(hits > RAYS / 3, "{name}: {hits} hits");
        }
    }
}

#[test]
fn soups_baked_at_any_scale_equal_brute_force() {
    for exponent in exponents() {
        let animation = random_animation(&Recipe {
            seed: 32,
            vertices: 60,
            joints: 5,
            scale: 10f32.powi(exponent),
            offset: 0.0,
            wild_scales: false,
            morph_targets: 1,
        });
        let name = format!("1e{exponent}");
        let hits =
            Stage::with(&baked_animation(&animation), Affine::IDENTITY, 2).assert_equals_brute_force(&name, RAYS, 32);
        assert!(hits > RAYS / 3, "{name}: {hits} hits");
    }
}

#[test]
fn instances_of_any_scale_equal_brute_force() {
    for (name, surface) in closed_surfaces() {
        for joints in [0, 4] {
            let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&surface, joints)));
            for exponent in exponents() {
                let name = format!("{name} at 1e{exponent}, {joints} joints");
                let hits = Stage::with(&asset, scaling(10f32.powi(exponent)), 3).assert_equals_brute_force(
                    &name,
                    RAYS / 2,
                    33,
                );
                assert!(hits > RAYS / 12, "{name}: {hits} hits");
            }
        }
    }
}

/// A unit model ten million units away, where neighbouring numbers are a unit apart: carried there by its instance, by
/// its bones, or resting there.
#[test]
fn a_unit_model_far_away_equals_brute_force() {
    let far = [1e7, -1e7, 1e7];
    for (name, surface) in closed_surfaces() {
        for joints in [0, 4] {
            let recipe = MeshRecipe::new(&surface, joints);
            let resting = MeshRecipe {
                rest_offset: far,
                ..recipe
            };
            let carried = MeshRecipe { carried: far, ..recipe };
            let moved = Affine::from_translation(far.map(|x| x as f32));
            for (way, recipe, transform) in [
                ("by instance", recipe, moved),
                ("by bones", carried, Affine::IDENTITY),
                ("by rest positions", resting, Affine::IDENTITY),
                (
                    "back by instance",
                    carried,
                    Affine::from_translation(far.map(|x| -x as f32)),
                ),
            ] {
                // Of one unit a point is left there, which no bake takes; of four units some triangles are.
                for scale in [1.0, 4.0, 16.0] {
                    if scale == 1.0 && way != "by instance" {
                        continue;
                    }
                    let surface = surface.clone().map(|p| p * scale);
                    let recipe = MeshRecipe {
                        surface: &surface,
                        ..recipe
                    };
                    let name = format!("{name} times {scale} {way}, {joints} joints");
                    let animation = jointed_mesh(&recipe);
                    let hits = Stage::with(&baked_animation(&animation), transform, 3).assert_equals_brute_force(
                        &name,
                        RAYS / 2,
                        34,
                    );
                    assert!(scale < 16.0 || hits > RAYS / 32, "{name}: {hits} hits");
                }
            }
        }
    }
}

/// Two instances a thousand million units apart, and a ray from each to the other.
#[test]
fn instances_far_apart_equal_brute_force() {
    for (size, distance) in [(1.0, 1e9f32), (1e6, 1e9), (1e-3, 1e9), (1.0, 1e18), (1e-10, 1e20)] {
        for joints in [0, 4] {
            let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&tube(), joints)));
            let mut stage = Stage::with(&asset, scaling(size), 3);
            let mut far = scaling(size);
            far.columns[3] = [0.6 * distance, 0.0, -0.8 * distance];
            stage.add(&asset, far, 4);
            let name = format!("size {size}, {distance} apart, {joints} joints");
            let hits = stage.assert_equals_brute_force(&name, RAYS, 35);
            assert!(hits > 0, "{name}: {hits} hits");
        }
    }
}
