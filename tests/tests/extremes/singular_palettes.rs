//! Bones that cannot be inverted, hardly can, or turn space inside out.

use restpose_runtime::{Affine, Asset};
use restpose_samples::solids::sphere;
use restpose_tests::{MeshRecipe, Stage, baked_animation, beads, jointed_mesh, tube};
use std::sync::Arc;

const RAYS: usize = 1_000;

/// A map by its singular values: stretched along its own axes, which are turned against those of the space on both sides.
fn stretched(values: [f64; 3]) -> Affine {
    let left = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    let right = [[0.6, 0.0, 0.8], [0.64, 0.6, -0.48], [-0.48, 0.8, 0.36]];
    let entry = |j: usize, k: usize| -> f64 { (0..3).map(|i| left[i][k] * values[i] * right[i][j]).sum() };
    let mut out = Affine::from_translation([0.25, -0.5, 0.125]);
    for j in 0..3 {
        out.columns[j] = std::array::from_fn(|k| entry(j, k) as f32);
    }
    out
}

/// Maps by name, and whether a cluster that follows one is traced through its tree.
fn maps() -> Vec<(&'static str, Affine, bool)> {
    let diagonal = |x: f32, y: f32, z: f32| Affine {
        columns: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [0.5, 0.25, -0.125]],
    };
    let scaled = |scale: f32| {
        let mut map = diagonal(scale, scale, scale);
        // Beside a translation nothing would be left of it.
        map.columns[3] = [0.0; 3];
        map
    };
    vec![
        ("turned", stretched([1.0, 1.0, 1.0]), true),
        ("mirrored", diagonal(-1.0, 1.0, 1.0), true),
        ("mirrored and turned", stretched([1.0, -1.0, 1.0]), true),
        ("turned inside out", stretched([-1.0, -1.0, -1.0]), true),
        ("uneven", diagonal(1e-2, 1.0, 1e2), true),
        ("condition 1e3", stretched([1.0, 0.03, 1e-3]), true),
        ("condition 4.5e4", stretched([1.0, 1.0, 1.0 / 45e3]), true),
        ("condition 4.5e4, mirrored", stretched([1.0, 1.0, -1.0 / 45e3]), true),
        ("condition 1e5", stretched([1.0, 1.0, 1e-5]), false),
        ("condition 1e7", stretched([1.0, 1.0, 1e-7]), false),
        ("condition 1e7, two ways", stretched([1.0, 1e-7, -1e-7]), false),
        ("condition beyond f32", stretched([1.0, 1.0, 1e-12]), false),
        ("flattened", diagonal(1.0, 0.0, 1.0), false),
        ("flattened and turned", stretched([1.0, 1.0, 0.0]), false),
        ("a line", stretched([0.0, 1.0, 0.0]), false),
        ("a point", diagonal(0.0, 0.0, 0.0), false),
        ("subnormal", scaled(1e-40), false),
        ("tiny", scaled(1e-12), true),
        ("huge", scaled(1e12), true),
        ("beyond the limit of scale", scaled(1e25), false),
    ]
}

/// Assets, and whether they are without residual motion.
fn assets() -> Vec<(&'static str, Arc<Asset>, bool)> {
    let half = sphere(2).map(|p| p * 0.5);
    let (beads, tube) = (beads(), tube());
    let all = [
        ("beads", &beads, true),
        ("sphere", &half, false),
        ("tube", &tube, false),
    ];
    all.into_iter()
        .map(|(name, surface, stiff)| {
            let recipe = MeshRecipe {
                stiff,
                ..MeshRecipe::new(surface, 4)
            };
            (name, baked_animation(&jointed_mesh(&recipe)), stiff)
        })
        .collect()
}

/// One bone at a time is given the map, then all of them.
#[test]
fn any_map_of_a_bone_equals_brute_force() {
    for (name, asset, stiff) in assets() {
        let bones = asset.model().bones.len();
        for (map_name, map, has_inverse) in maps() {
            for bone in [None, Some(bones - 2), Some(bones - 1)] {
                let mut stage = Stage::default();
                let instance = stage.add(&asset, Affine::IDENTITY, 3);
                let mut palette = stage.scene.pose(instance).unwrap().palette;
                for (index, entry) in palette.iter_mut().enumerate() {
                    if bone.is_none_or(|bone| bone == index) {
                        *entry = map;
                    }
                }
                stage.scene.set_palette(instance, &palette, &[]).unwrap();
                let name = format!("{name}, {map_name}, bone {bone:?}");
                let hits = stage.assert_equals_brute_force(&name, RAYS / 2, 61);
                assert!(
                    hits > 0 || map_name == "a point" || map_name.contains("line"),
                    "{name}: no hit"
                );
                let (frame, ..) = stage.commit();
                let moved = |cluster: &restpose_runtime::ClusterBounds| {
                    let own = asset.model().clusters[cluster.cluster as usize].bone as usize;
                    bone.is_none_or(|bone| bone == own)
                };
                assert!(
                    !stiff
                        || frame
                            .clusters()
                            .filter(moved)
                            .all(|cluster| cluster.has_inverse == has_inverse),
                    "{name}: a cluster has an inverse or has none against the table"
                );
            }
        }
    }
}

/// The same maps as instance transforms, which leave no pose space.
#[test]
fn any_instance_transform_equals_brute_force() {
    for joints in [0, 4] {
        let asset = baked_animation(&jointed_mesh(&MeshRecipe::new(&tube(), joints)));
        for (name, map, _) in maps() {
            for sample in [0, 3] {
                let name = format!("{name}, {joints} joints, sample {sample}");
                Stage::with(&asset, map, sample).assert_equals_brute_force(&name, RAYS / 2, 62);
            }
        }
    }
}

/// A transform whose inverse is another's product: nearly singular factors whose product is not, and the reverse.
#[test]
fn singular_factors_equal_brute_force() {
    for (name, asset, _) in assets() {
        for (first, second) in [
            ([1.0, 1.0, 1e-7], [1.0, 1.0, 1e7]),
            ([1.0, 1e-4, 1.0], [1.0, 1e-4, 1.0]),
            ([1e-9, 1e-9, 1e-9], [1e9, 1e9, 1e9]),
            ([1e15, 1e15, 1e15], [1e15, 1e15, 1e15]),
        ] {
            let mut stage = Stage::default();
            let instance = stage.add(&asset, stretched(first), 3);
            let palette: Vec<Affine> = stage.scene.pose(instance).unwrap().palette;
            let stretched: Vec<Affine> = palette.iter().map(|bone| stretched(second) * *bone).collect();
            stage.scene.set_palette(instance, &stretched, &[]).unwrap();
            let name = format!("{name}, {first:?} after {second:?}");
            stage.assert_equals_brute_force(&name, RAYS, 63);
        }
    }
}

/// Bones of one skin a kilometre apart, in poses that the clip contains or that rigid parts allow.
#[test]
fn bones_a_kilometre_apart_equal_brute_force() {
    for (name, asset, _) in assets() {
        for distance in [1e3f32, 1e6, 1e9] {
            let mut stage = Stage::default();
            let instance = stage.add(&asset, Affine::IDENTITY, 3);
            let mut palette = stage.scene.pose(instance).unwrap().palette;
            for (index, bone) in palette.iter_mut().enumerate() {
                bone.columns[3][index % 3] += distance * index as f32;
            }
            stage.scene.set_palette(instance, &palette, &[]).unwrap();
            let hits = stage.assert_equals_brute_force(&format!("{name}, {distance} apart"), 2 * RAYS, 64);
            assert!(hits > 0, "{name}, {distance}");
        }
    }
}
