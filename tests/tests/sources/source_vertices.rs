//! The runtime's vertices are the source's: against an evaluation in `f64` written from the glTF 2.0 specification
//! alone, which shares no code with importer, baker or runtime.

use restpose_runtime::Scene;
use restpose_tests::{baked_asset, gltf_reference::Reference, source_scenes};

/// Relative to the diagonal of the posed model. A vertex takes under 16 roundings to `f32` (palette entries, products,
/// weights, sums), each 6e-8 of numbers that may be several times the model's size.
const TOLERANCE: f64 = 2e-6;

#[test]
fn posed_vertices_equal_the_specification() {
    for path in source_scenes() {
        let reference = Reference::load(&path);
        let (_, asset) = baked_asset(&path);
        let model = asset.model();
        assert_eq!(model.parts.len(), reference.parts().len(), "{}", path.display());
        assert_eq!(model.clips.len(), reference.clip_count(), "{}", path.display());
        for (row, part) in model.parts.iter().zip(reference.parts()) {
            assert_eq!(
                (row.source_node as usize, row.source_mesh as usize),
                (part.node, part.mesh)
            );
        }

        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        let mut poses: Vec<(Option<usize>, f32)> = vec![(None, 0.0)];
        for (clip, row) in model.clips.iter().enumerate() {
            let (start, end) = (row.start_seconds, row.end_seconds);
            // Off the keys as well as on them, and past the end.
            let fractions = [0.0, 0.137, 0.25, 0.5, 0.731, 1.0, 1.2];
            poses.extend(fractions.map(|fraction| (Some(clip), start + fraction * (end - start))));
        }
        for (clip, seconds) in poses {
            match clip {
                Some(clip) => scene.play(instance, clip, seconds).unwrap(),
                None => scene.set_default_pose(instance).unwrap(),
            }
            let frame = scene.commit();
            let expected: Vec<[f64; 3]> = (0..reference.parts().len())
                .flat_map(|part| reference.positions(part, clip, f64::from(seconds)))
                .flatten()
                .collect();
            assert_eq!(expected.len() + 1, model.vertices.len(), "{}", path.display());
            let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for p in &expected {
                low = std::array::from_fn(|k| low[k].min(p[k]));
                high = std::array::from_fn(|k| high[k].max(p[k]));
            }
            let length = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            let limit = TOLERANCE * length(low, high);
            for (vertex, expected) in (0u32..).zip(&expected) {
                let found = frame.vertex(instance, vertex).unwrap().map(f64::from);
                let error = length(found, *expected);
                let place = format!("{}: vertex {vertex}, clip {clip:?} at {seconds} s", path.display());
                assert!(
                    error <= limit,
                    "{place}: {found:?} is {error} from {expected:?}, more than {limit}"
                );
            }
        }
    }
}

/// Triangles stand in the source's order and numbering; only degenerate ones have lost their corners.
#[test]
fn triangles_keep_the_sources_numbering() {
    for path in source_scenes() {
        let reference = Reference::load(&path);
        let (_, asset) = baked_asset(&path);
        let model = asset.model();
        let mut triangle = 0;
        let mut vertex_first = 0;
        for (part, row) in model.parts.iter().enumerate() {
            let vertices = reference.positions(part, None, 0.0);
            for (primitive, triangles) in reference.triangles(part).into_iter().enumerate() {
                let primitive_row = model.primitives[row.primitive_first as usize + primitive];
                assert_eq!(primitive_row.triangle_first, triangle, "{}", path.display());
                assert_eq!(
                    primitive_row.triangle_count as usize,
                    triangles.len(),
                    "{}",
                    path.display()
                );
                for corners in triangles {
                    let expected = corners.map(|corner| vertex_first + corner as u32);
                    let found = model.triangles[triangle as usize].corners;
                    let degenerate = found[0] == found[1] && found[1] == found[2];
                    assert!(
                        found == expected || degenerate,
                        "{}: {found:?} is not {expected:?}",
                        path.display()
                    );
                    triangle += 1;
                }
                vertex_first += vertices[primitive].len() as u32;
            }
        }
        assert_eq!(triangle as usize, model.triangles.len());
    }
}
