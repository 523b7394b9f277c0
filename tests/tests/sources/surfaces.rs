//! What a hit says of itself, against the source evaluated from the specification.

use restpose_bake::verify::{Oracle, Rays};
use restpose_runtime::Scene;
use restpose_tests::{baked_asset, gltf_reference::Reference, source_scenes};

/// Of the model's size: rounding of `f32` vertices, hit distances and barycentric weights of a few 1e-7 each. Hits of
/// rays that run almost within a triangle are left out: there a rounded `t` slides far along it.
const TOLERANCE: f64 = 1e-5;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

#[test]
fn hits_name_the_sources_triangle_point_bone_and_normal() {
    for path in source_scenes() {
        let reference = Reference::load(&path);
        let (animation, asset) = baked_asset(&path);
        let model = asset.model();
        let sample = model.samples[model.samples.len() / 2];
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        scene.play(instance, sample.clip as usize, sample.seconds).unwrap();
        let frame = scene.commit();
        let bounds = frame.bounds();
        let size = f64::from((0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max));
        let positions: Vec<_> = (0..model.parts.len())
            .map(|part| reference.positions(part, Some(sample.clip as usize), f64::from(sample.seconds)))
            .collect();
        let triangles: Vec<_> = (0..model.parts.len()).map(|part| reference.triangles(part)).collect();

        let oracle = Oracle::new(&frame, &[instance]);
        let mut checked = 0;
        for ray in Rays::new(&oracle, 31).step_by(7).take(600) {
            let Some(hit) = frame.closest_hit(&ray) else { continue };
            let surface = frame.surface(&hit).unwrap();
            let part = surface.part as usize;
            assert_eq!(surface.source_node as usize, reference.parts()[part].node);
            assert_eq!(surface.source_mesh as usize, reference.parts()[part].mesh);
            let primitive = surface.source_primitive as usize;
            let corners = triangles[part][primitive][surface.source_triangle as usize];
            let [a, b, c] = corners.map(|corner| positions[part][primitive][corner]);
            let (u, v) = (f64::from(hit.u), f64::from(hit.v));
            let point: [f64; 3] = std::array::from_fn(|k| (1.0 - u - v) * a[k] + u * b[k] + v * c[k]);

            let (e, f): ([f64; 3], [f64; 3]) = (
                std::array::from_fn(|k| b[k] - a[k]),
                std::array::from_fn(|k| c[k] - a[k]),
            );
            let cross = [
                e[1] * f[2] - e[2] * f[1],
                e[2] * f[0] - e[0] * f[2],
                e[0] * f[1] - e[1] * f[0],
            ];
            let area = dot(cross, cross).sqrt();
            let direction = ray.direction.map(f64::from);
            let slope = dot(cross, direction).abs() / (area * dot(direction, direction).sqrt());
            if slope.is_nan() || slope < 0.05 || area.sqrt() < 1e-3 * size {
                continue;
            }
            checked += 1;
            for k in 0..3 {
                let found = f64::from(surface.position_world[k]);
                assert!(
                    (found - point[k]).abs() < TOLERANCE * size,
                    "{}: {found} {}",
                    path.display(),
                    point[k]
                );
                let along = f64::from(ray.origin[k]) + f64::from(hit.t) * direction[k];
                assert!(
                    (along - point[k]).abs() < 10.0 * TOLERANCE * size,
                    "{}: {along} {}",
                    path.display(),
                    point[k]
                );
                let normal = cross[k] / area;
                assert!(
                    (f64::from(surface.normal_world[k]) - normal).abs() < 0.01,
                    "{}",
                    path.display()
                );
            }

            // The bone: of all that move the corners, none has more weight at the point.
            let rows = model.triangles[hit.triangle as usize].corners;
            let weight_of = |bone: u32| -> f64 {
                let at = |corner: u32| -> f64 {
                    let own = model
                        .influences_of(corner as usize)
                        .iter()
                        .filter(|influence| influence.bone == bone);
                    own.map(|influence| f64::from(influence.weight)).sum()
                };
                (1.0 - u - v) * at(rows[0]) + u * at(rows[1]) + v * at(rows[2])
            };
            let heaviest = (0..model.bones.len() as u32).map(weight_of).fold(0.0, f64::max);
            assert!(weight_of(surface.bone) >= heaviest - 1e-12, "{}", path.display());

            // The rest point: between the source's own rest positions, where the part keeps its rest space.
            let row = model.parts[part];
            let mesh = &animation.meshes[row.source_mesh as usize];
            let source = mesh
                .primitives
                .iter()
                .find(|p| p.source_primitive == primitive)
                .unwrap();
            if row.class != 0 && mesh.morph_target_count == 0 {
                let [a, b, c] = corners.map(|corner| source.positions[corner].map(f64::from));
                for k in 0..3 {
                    let rest = (1.0 - u - v) * a[k] + u * b[k] + v * c[k];
                    let found = f64::from(surface.position_rest[k]);
                    assert!(
                        (found - rest).abs() <= 1e-6 * (a[k].abs() + b[k].abs() + c[k].abs()),
                        "{}",
                        path.display()
                    );
                }
            }
        }
        assert!(checked > 50, "{}: {checked}", path.display());
    }
}
