//! Import agrees with the `gltf` crate wherever that crate reads a file.
//!
//! The importer has its own reader because that crate refuses `KHR_mesh_quantization` and panics on bad indices; on
//! ordinary files the two must see the same numbers.

use restpose_bake::import::{Influence, import};
use restpose_tests::source_scenes;
use std::{fs, path::Path};

/// The buffers of a file, if all of them are its binary chunk or files beside it.
fn buffers(path: &Path, file: &gltf::Gltf) -> Option<Vec<Vec<u8>>> {
    let load = |buffer: gltf::Buffer| match buffer.source() {
        gltf::buffer::Source::Bin => file.blob.clone(),
        gltf::buffer::Source::Uri(uri) => fs::read(path.with_file_name(uri)).ok(),
    };
    file.buffers().map(load).collect()
}

#[test]
fn geometry_and_weights_equal_those_of_the_gltf_crate() {
    let mut compared = 0;
    for path in source_scenes() {
        let Ok(file) = gltf::Gltf::open(&path) else { continue };
        let Some(buffers) = buffers(&path, &file) else { continue };
        let animation = import(&path).unwrap().animation;
        for mesh in file.meshes() {
            let triangles = |primitive: &gltf::Primitive| primitive.mode() == gltf::mesh::Mode::Triangles;
            for (theirs, ours) in mesh.primitives().zip(&animation.meshes[mesh.index()].primitives) {
                if !triangles(&theirs) {
                    continue;
                }
                let reader = theirs.reader(|buffer| Some(&buffers[buffer.index()]));
                let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
                assert_eq!(ours.positions, positions, "{}", path.display());
                if let Some(indices) = reader.read_indices() {
                    let indices: Vec<u32> = indices.into_u32().collect();
                    assert_eq!(ours.triangles.as_flattened(), indices, "{}", path.display());
                }
                if let (Some(joints), Some(weights), None) =
                    (reader.read_joints(0), reader.read_weights(0), reader.read_joints(1))
                {
                    let weights: Vec<[f32; 4]> = weights.into_f32().collect();
                    for (vertex, (joints, weights)) in joints.into_u16().zip(weights).enumerate() {
                        let mut expected: Vec<(usize, f32)> = joints
                            .into_iter()
                            .map(usize::from)
                            .zip(weights)
                            .filter(|(_, weight)| *weight > 0.0)
                            .collect();
                        expected.sort_by_key(|(joint, _)| *joint);
                        let found = &ours.influences[vertex];
                        // The crate multiplies by 1/255 where the specification divides by 255: an ulp apart.
                        let alike = |(ours, theirs): (&Influence, &(usize, f32))| {
                            ours.joint == theirs.0 && (ours.weight - theirs.1).abs() <= f32::EPSILON * theirs.1
                        };
                        let same = found.len() == expected.len() && found.iter().zip(&expected).all(alike);
                        assert!(same, "{}: vertex {vertex}: {found:?} {expected:?}", path.display());
                    }
                }
                compared += 1;
            }
        }
        for (theirs, ours) in file.animations().zip(&animation.clips) {
            assert_eq!(theirs.name().unwrap_or_default(), ours.name);
            for (theirs, ours) in theirs.channels().zip(&ours.channels) {
                let reader = theirs.reader(|buffer| Some(&buffers[buffer.index()]));
                assert!(
                    reader.read_inputs().unwrap().eq(ours.times.iter().copied()),
                    "{}",
                    path.display()
                );
                assert_eq!(theirs.target().node().index(), ours.node);
            }
        }
    }
    assert!(compared > 0, "some bundled sample is a file that the crate reads");
}
