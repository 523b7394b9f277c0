//! A skinned figure in a glTF document: its bone nodes, its skin, its poses.

use crate::column::{Column, Component, narrow_rotation, narrow3};
use crate::gltf_json::{Mesh, Node, Skin};
use crate::gltf_writer::{GltfWriter, Track, primitive, with_tangents};
use crate::rotation::with_continuous_signs;
use crate::skinning::{Bone, four_influence_columns};
use crate::surface::Surface;
use glam::{DMat4, DQuat, DVec3};

/// Bones and the nodes that stand for them.
///
/// In the bind pose no bone is rotated, so a bone's rotation in figure space says how far it has turned since.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// Bones, parents first.
    pub bones: Vec<Bone>,
    /// One node per bone.
    pub nodes: Vec<usize>,
}

impl Skeleton {
    /// Adds a node per bone under `parent`, in the pose of `rest` (figure space, one rotation per bone).
    pub fn add(writer: &mut GltfWriter, parent: usize, bones: Vec<Bone>, rest: &[DQuat]) -> Skeleton {
        let mut nodes = Vec::new();
        for (bone, local) in bones.iter().zip(local_rotations(&bones, rest)) {
            let (parent_node, origin) = match bone.parent {
                Some(index) => (nodes[index], bones[index].joint),
                None => (parent, DVec3::ZERO),
            };
            let node = Node {
                name: bone.name.clone(),
                translation: Some(narrow3(bone.joint - origin)),
                rotation: (local != DQuat::IDENTITY).then_some(narrow_rotation(local)),
                ..Node::default()
            };
            nodes.push(writer.add_child(parent_node, node));
        }
        Skeleton { bones, nodes }
    }

    /// Adds the skin over all bones.
    pub fn add_skin(&self, writer: &mut GltfWriter, name: &str) -> usize {
        let inverse_bind: Vec<_> = self
            .bones
            .iter()
            .map(|bone| DMat4::from_translation(-bone.joint))
            .collect();
        let inverse_bind_matrices = writer.add_column(&Column::matrices(&inverse_bind));
        writer.add_skin(Skin {
            name: name.to_owned(),
            inverse_bind_matrices,
            skeleton: self.nodes.first().copied(),
            joints: self.nodes.clone(),
        })
    }

    /// A linear rotation track per bone that moves, from poses in figure space.
    ///
    /// Shapes: `poses` is `[key][bone]`.
    pub fn linear_tracks(&self, times: &[f64], poses: &[Vec<DQuat>]) -> Vec<Track> {
        self.tracks(poses, |node, rotations| Track {
            node,
            path: "rotation",
            interpolation: "LINEAR",
            times: times.to_vec(),
            values: Column::rotations(&rotations),
        })
    }

    /// A cubic spline rotation track per bone that moves, from poses in figure space.
    ///
    /// Shapes: `poses` is `[key][bone]`.
    pub fn spline_tracks(&self, times: &[f64], poses: &[Vec<DQuat>]) -> Vec<Track> {
        self.tracks(poses, |node, rotations| {
            let values: Vec<_> = with_continuous_signs(rotations)
                .into_iter()
                .map(|rotation| rotation.to_array())
                .collect();
            Track {
                node,
                path: "rotation",
                interpolation: "CUBICSPLINE",
                times: times.to_vec(),
                values: Column::floats(&with_tangents(times, &values)),
            }
        })
    }

    fn tracks(&self, poses: &[Vec<DQuat>], track: impl Fn(usize, Vec<DQuat>) -> Track) -> Vec<Track> {
        let keys: Vec<_> = poses.iter().map(|pose| local_rotations(&self.bones, pose)).collect();
        let of_bone = |bone: usize| keys.iter().map(|key| key[bone]).collect::<Vec<_>>();
        (0..self.bones.len())
            .map(|bone| (self.nodes[bone], of_bone(bone)))
            .filter(|(_, rotations)| {
                // Compared as stored, so that rounding in f64 alone makes no track.
                let first = narrow_rotation(rotations[0]);
                rotations.iter().any(|&rotation| narrow_rotation(rotation) != first)
            })
            .map(|(node, rotations)| track(node, rotations))
            .collect()
    }
}

/// Rotations relative to the parent bone, from rotations in figure space.
fn local_rotations(bones: &[Bone], rotations: &[DQuat]) -> Vec<DQuat> {
    bones
        .iter()
        .zip(rotations)
        .map(|(bone, &rotation)| match bone.parent {
            // An unmoved bone under an unmoved or equally moved parent stays at exactly nothing.
            Some(parent) if rotations[parent] == rotation => DQuat::IDENTITY,
            Some(parent) => (rotations[parent].conjugate() * rotation).normalize(),
            None => rotation,
        })
        .collect()
}

/// Adds a skinned mesh with the given normals, all attributes interleaved, and the root node that shows it.
pub fn add_skinned_surface(
    writer: &mut GltfWriter,
    name: &str,
    surface: &Surface,
    normals: Column,
    influences: &[Vec<(usize, f64)>],
    weight_component: Component,
    (skin, material): (usize, usize),
) -> usize {
    let [joints, weights] = four_influence_columns(influences, weight_component);
    let attributes = writer.add_interleaved(&[
        ("POSITION", Column::vectors(&surface.positions)),
        ("NORMAL", normals),
        ("JOINTS_0", joints),
        ("WEIGHTS_0", weights),
    ]);
    let mut primitive = primitive(attributes);
    primitive.indices = Some(writer.add_indices(surface.triangles.as_flattened(), Component::U16));
    primitive.material = Some(material);
    let mesh = writer.add_mesh(Mesh {
        name: name.to_owned(),
        primitives: vec![primitive],
        ..Mesh::default()
    });
    writer.add_root(Node {
        name: name.to_owned(),
        mesh: Some(mesh),
        skin: Some(skin),
        ..Node::default()
    })
}
