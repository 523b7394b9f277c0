//! The flower of `mixed.glb`: a stalk of bones whose head opens by morph targets, so morphed first, then skinned.

use crate::column::{Column, Component, narrow3};
use crate::figure::Skeleton;
use crate::gltf_json::{Mesh, MeshExtras, Node};
use crate::gltf_writer::{GltfWriter, Track, primitive, with_tangents};
use crate::rotation::{about_x, about_z, cos_turn, sin_turn};
use crate::skinning::{Bone, four_influence_columns};
use crate::solids::loft;
use crate::surface::Surface;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;

const BONE_COUNT: usize = 5;
const BONE_LENGTH: f64 = 0.2;
const SIDES: u32 = 20;
const PETALS: f64 = 5.0;

/// A ring of the flower: radius and height closed, and the same opened.
struct Ring {
    closed: (f64, f64),
    open: (f64, f64),
    /// How far the petals stand out of the round, as a part of the radius.
    petals: f64,
}

fn rings() -> Vec<Ring> {
    let mut rings: Vec<Ring> = (0..=12_u32)
        .map(|step| {
            let height = f64::from(step) * 0.068;
            let foot = (1.0 - height / 0.2).max(0.0);
            let place = (0.035 + 0.05 * foot * foot, height);
            Ring {
                closed: place,
                open: place,
                petals: 0.0,
            }
        })
        .collect();
    // The outside of the head up to its rim, then the inside down into the throat.
    let head = [
        ((0.07, 0.85), (0.07, 0.84), 0.0),
        ((0.14, 0.92), (0.14, 0.87), 0.05),
        ((0.16, 1.0), (0.24, 0.92), 0.12),
        ((0.14, 1.08), (0.33, 0.99), 0.2),
        ((0.09, 1.14), (0.4, 1.08), 0.26),
        ((0.06, 1.15), (0.385, 1.1), 0.26),
        ((0.05, 1.12), (0.28, 1.03), 0.2),
        ((0.045, 1.08), (0.18, 0.97), 0.12),
        ((0.035, 1.05), (0.08, 0.93), 0.05),
    ];
    rings.extend(head.map(|(closed, open, petals)| Ring { closed, open, petals }));
    rings
}

fn ring_points((radius, height): (f64, f64), petals: f64) -> Vec<DVec3> {
    (0..SIDES)
        .map(|side| {
            let turn = f64::from(side) / f64::from(SIDES);
            let radius = radius * (1.0 + petals * cos_turn(PETALS * turn));
            DVec3::new(radius * sin_turn(turn), height, radius * cos_turn(turn))
        })
        .collect()
}

/// Closed, and opened: two surfaces of the same triangles.
fn surfaces() -> [Surface; 2] {
    let closed: Vec<_> = rings()
        .iter()
        .map(|ring| ring_points(ring.closed, ring.petals * 0.5))
        .collect();
    let open: Vec<_> = rings().iter().map(|ring| ring_points(ring.open, ring.petals)).collect();
    let closed = loft(&closed);
    // A quadrilateral's shorter diagonal may differ when opened: the closed flower decides.
    let open = Surface {
        positions: loft(&open).positions,
        triangles: closed.triangles.clone(),
    };
    [closed, open]
}

/// The flower's nodes that clips move.
pub struct Flower {
    /// Its bones.
    pub skeleton: Skeleton,
    /// The node whose weights open and twist it.
    pub surface_node: usize,
}

/// Adds the flower under a placed armature node.
pub fn add_flower(writer: &mut GltfWriter, armature: Node, material: usize) -> Flower {
    let parent = writer.add_root(armature);
    let bones: Vec<_> = (0..BONE_COUNT)
        .map(|index| Bone {
            name: format!("stalk_{index}"),
            parent: index.checked_sub(1),
            joint: DVec3::new(0.0, index as f64 * BONE_LENGTH, 0.0),
        })
        .collect();
    let still = [DQuat::IDENTITY; BONE_COUNT];
    let skeleton = Skeleton::add(writer, parent, bones, &still);
    let skin = skeleton.add_skin(writer, "flower_skin");

    let [closed, open] = surfaces();
    let influences: Vec<_> = closed.positions.iter().map(influences).collect();
    let [joints, weights] = four_influence_columns(&influences, Component::U8);
    let attributes = writer.add_attributes(&[
        ("POSITION", Column::vectors(&closed.positions)),
        ("JOINTS_0", joints),
        ("WEIGHTS_0", weights),
    ]);
    let mut primitive = primitive(attributes);
    primitive.indices = Some(writer.add_indices(closed.triangles.as_flattened(), Component::U16));
    primitive.material = Some(material);
    let displacement = |to: &Surface| -> Vec<[f32; 3]> {
        let pairs = to.positions.iter().zip(&closed.positions);
        pairs.map(|(to, from)| narrow3(*to - *from)).collect()
    };
    let twisted = closed.clone().map(twisted);
    for target in [&open, &twisted] {
        let accessor = writer.add_sparse_displacements(&displacement(target));
        primitive
            .targets
            .push(BTreeMap::from([("POSITION".to_owned(), accessor)]));
    }
    let mesh = writer.add_mesh(Mesh {
        name: "flower".to_owned(),
        primitives: vec![primitive],
        weights: vec![0.15, 0.0],
        extras: Some(MeshExtras {
            target_names: vec!["open".to_owned(), "twist".to_owned()],
        }),
    });
    let surface_node = writer.add_root(Node {
        name: "flower_surface".to_owned(),
        mesh: Some(mesh),
        skin: Some(skin),
        ..Node::default()
    });
    Flower { skeleton, surface_node }
}

/// The head turned about its own axis, more the higher up.
fn twisted(point: DVec3) -> DVec3 {
    let above = (point.y - 0.85).max(0.0);
    crate::rotation::about_y(160.0 * above) * point
}

fn influences(position: &DVec3) -> Vec<(usize, f64)> {
    let bones_up = position.y / BONE_LENGTH;
    let mut weights: Vec<(usize, f64)> = (0..BONE_COUNT)
        .map(|bone| {
            // The last bone carries the whole head.
            let middle = bone as f64 + 0.5;
            let away = match bone + 1 == BONE_COUNT {
                true => (middle - bones_up).max(0.0),
                false => (middle - bones_up).abs(),
            };
            (bone, (1.0 - away / 1.2).max(0.0))
        })
        .filter(|&(_, weight)| weight > 0.0)
        .collect();
    weights.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    weights.truncate(4);
    weights
}

/// Opens and closes once in `seconds` while the stalk nods.
pub fn bloom(flower: &Flower, seconds: f64) -> Vec<Track> {
    let phases = [0.0, 0.25, 0.5, 0.75, 1.0];
    let times = phases.map(|phase| phase * seconds);
    let weights = [[0.15, 0.0], [0.6, 0.3], [1.0, 0.0], [0.6, -0.3], [0.15, 0.0]];
    // glTF interleaves a weights spline by key: in-tangents, values, out-tangents of all targets.
    let keys: Vec<f32> = with_tangents(&times, &weights).into_iter().flatten().collect();
    let scalars: Vec<[f32; 1]> = keys.into_iter().map(|key| [key]).collect();
    let mut tracks = vec![Track {
        node: flower.surface_node,
        path: "weights",
        interpolation: "CUBICSPLINE",
        times: times.to_vec(),
        values: Column::floats(&scalars),
    }];
    tracks.extend(nod(&flower.skeleton, seconds, 9.0));
    tracks
}

/// The stalk swings in a circle once in `seconds`, by `degrees` per bone.
pub fn nod(skeleton: &Skeleton, seconds: f64, degrees: f64) -> Vec<Track> {
    let keys = 8_u32;
    let (times, poses): (Vec<f64>, Vec<Vec<DQuat>>) = (0..=keys)
        .map(|key| {
            let turn = f64::from(key) / f64::from(keys);
            let bend = about_z(degrees * sin_turn(turn)) * about_x(degrees * cos_turn(turn));
            let mut pose = vec![DQuat::IDENTITY];
            for bone in 1..BONE_COUNT {
                pose.push(pose[bone - 1] * bend);
            }
            (seconds * turn, pose)
        })
        .unzip();
    skeleton.spline_tracks(&times, &poses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_and_open_are_closed_surfaces() {
        for surface in surfaces() {
            assert!(surface.is_closed_manifold());
            assert!(surface.volume() > 0.0);
        }
    }
}
