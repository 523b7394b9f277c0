//! `tentacle.gltf` and `tentacle.bin`: a long chain of bones with eight influences per vertex.

use crate::column::{Column, Component, narrow};
use crate::figure::Skeleton;
use crate::flat_mesh::add_flat_mesh;
use crate::gltf_json::{Mesh, Node};
use crate::gltf_writer::{GltfWriter, WriteError, primitive};
use crate::rotation::{about_x, about_z, cos_turn, sin_turn};
use crate::skinning::Bone;
use crate::solids::{lathe, loft};
use crate::surface::Surface;
use glam::{DQuat, DVec3};

const BONE_COUNT: usize = 24;
/// Distance between joints, scene units.
const BONE_LENGTH: f64 = 0.12;
const SIDES: u32 = 14;
const RINGS_PER_BONE: u32 = 3;
const INFLUENCES: usize = 8;

/// The scene's text and the buffer that it expects beside it under the name `buffer_name`.
///
/// # Errors
/// [`WriteError`] as [`GltfWriter::into_gltf_and_buffer`] says.
pub fn tentacle_gltf_and_bin(buffer_name: &str) -> Result<(Vec<u8>, Vec<u8>), WriteError> {
    let mut writer = GltfWriter::new("tentacle");
    let skin_colour = writer.add_material("skin", [0.45, 0.16, 0.42]);
    let rock_colour = writer.add_material("rock", [0.4, 0.39, 0.36]);

    let armature = writer.add_root(Node {
        name: "tentacle".to_owned(),
        ..Node::default()
    });
    let still = vec![DQuat::IDENTITY; BONE_COUNT];
    let skeleton = Skeleton::add(&mut writer, armature, bones(), &still);
    let skin = skeleton.add_skin(&mut writer, "tentacle_skin");

    let surface = surface();
    let mut attributes = vec![
        ("POSITION", Column::vectors(&surface.positions)),
        ("NORMAL", Column::vectors(&surface.normals())),
    ];
    attributes.extend(influence_columns(&surface));
    let mut primitive = primitive(writer.add_attributes(&attributes));
    primitive.indices = Some(writer.add_indices(surface.triangles.as_flattened(), Component::U16));
    primitive.material = Some(skin_colour);
    let mesh = writer.add_mesh(Mesh {
        name: "tentacle_skin_surface".to_owned(),
        primitives: vec![primitive],
        ..Mesh::default()
    });
    writer.add_root(Node {
        name: "tentacle_surface".to_owned(),
        mesh: Some(mesh),
        skin: Some(skin),
        ..Node::default()
    });

    let rock = add_flat_mesh(&mut writer, "rock", &rock(), rock_colour);
    writer.add_root(Node {
        name: "rock".to_owned(),
        mesh: Some(rock),
        ..Node::default()
    });

    let (times, poses) = curl();
    writer.add_clip("curl", &skeleton.linear_tracks(&times, &poses));
    let (times, poses) = sway();
    writer.add_clip("sway", &skeleton.spline_tracks(&times, &poses));
    writer.into_gltf_and_buffer(buffer_name)
}

fn bones() -> Vec<Bone> {
    (0..BONE_COUNT)
        .map(|index| Bone {
            name: format!("segment_{index:02}"),
            parent: index.checked_sub(1),
            joint: DVec3::new(0.0, index as f64 * BONE_LENGTH, 0.0),
        })
        .collect()
}

/// Radius at a height given in bones: a flared foot, then a taper.
fn radius(bones_up: f64) -> f64 {
    let along = bones_up / BONE_COUNT as f64;
    let taper = 0.2 * (1.0 - along) + 0.035;
    let flare = 0.16 * (1.0 - bones_up / 3.0).max(0.0);
    taper + flare * (1.0 - bones_up / 3.0).max(0.0)
}

/// The tube: round at the back, with a row of swellings like suckers along the front (+x).
fn surface() -> Surface {
    let ring_count = BONE_COUNT as u32 * RINGS_PER_BONE;
    let tube = (0..=ring_count).map(|ring| {
        let bones_up = f64::from(ring) / f64::from(RINGS_PER_BONE);
        let bulge = 0.5 - 0.5 * cos_turn(bones_up);
        ring_at(bones_up * BONE_LENGTH, radius(bones_up), bulge)
    });
    // The tip is half a ball.
    let top = BONE_COUNT as f64 * BONE_LENGTH;
    let end = radius(BONE_COUNT as f64);
    let tip = [1.0, 2.0].map(|step| {
        let turn = step / 12.0;
        ring_at(top + end * sin_turn(turn), end * cos_turn(turn), 0.0)
    });
    loft(&tube.chain(tip).collect::<Vec<_>>())
}

fn ring_at(height: f64, radius: f64, bulge: f64) -> Vec<DVec3> {
    (0..SIDES)
        .map(|side| {
            let turn = f64::from(side) / f64::from(SIDES);
            let front = sin_turn(turn).max(0.0);
            let radius = radius * (1.0 + 0.28 * bulge * front * front * front);
            DVec3::new(radius * sin_turn(turn), height, radius * cos_turn(turn))
        })
        .collect()
}

fn rock() -> Surface {
    lathe(
        &[(0.95, -0.16), (1.0, -0.1), (0.93, -0.03), (0.55, 0.02), (0.4, 0.05)],
        32,
    )
}

/// `JOINTS_0`, `WEIGHTS_0`, `JOINTS_1` and `WEIGHTS_1`: the eight bones nearest in height, as floats.
fn influence_columns(surface: &Surface) -> [(&'static str, Column); 4] {
    let mut joints = [Vec::new(), Vec::new()];
    let mut weights = [Vec::new(), Vec::new()];
    for position in &surface.positions {
        let row = influences(position.y / BONE_LENGTH);
        for (half, four) in row.chunks(4).enumerate() {
            joints[half].push(core::array::from_fn::<i64, 4, _>(|slot| four[slot].0));
            weights[half].push(core::array::from_fn::<f32, 4, _>(|slot| four[slot].1));
        }
    }
    let bytes = |rows: &[[i64; 4]]| Column::integers(Component::U8, false, rows);
    [
        ("JOINTS_0", bytes(&joints[0])),
        ("WEIGHTS_0", Column::floats(&weights[0])),
        ("JOINTS_1", bytes(&joints[1])),
        ("WEIGHTS_1", Column::floats(&weights[1])),
    ]
}

/// Eight bones and their weights, which sum to one, for a height given in bones.
///
/// A bone weighs by a bell around its middle that reaches four bones to either side.
fn influences(bones_up: f64) -> Vec<(i64, f32)> {
    let last = (BONE_COUNT - INFLUENCES) as f64;
    let first = (bones_up - 4.0).floor().clamp(0.0, last);
    let exact: Vec<(i64, f64)> = (0..INFLUENCES)
        .map(|slot| {
            let bone = first + slot as f64;
            let away = (bones_up - (bone + 0.5)) / 4.5;
            let bell = (1.0 - away * away).max(0.0);
            // A high power of the parabola: about one bone wide at half its height.
            let squared = bell * bell;
            let fourth = squared * squared;
            (bone as i64, fourth * fourth * fourth)
        })
        .collect();
    let sum: f64 = exact.iter().map(|(_, weight)| weight).sum();
    let stored: Vec<(i64, f32)> = exact
        .iter()
        .map(|&(bone, weight)| (bone, narrow(weight / sum)))
        .collect();
    // A joint without weight must be joint zero.
    let named = |&(bone, weight): &(i64, f32)| (if weight > 0.0 { bone } else { 0 }, weight);
    stored.iter().map(named).collect()
}

/// A pose from each bone's bend relative to the bone below: degrees about z and about x.
fn bent(bend: impl Fn(f64) -> (f64, f64)) -> Vec<DQuat> {
    let mut pose: Vec<DQuat> = Vec::new();
    for bone in 0..BONE_COUNT {
        let below = pose.last().copied().unwrap_or(DQuat::IDENTITY);
        let (sideways, forward) = bend(bone as f64);
        pose.push(below * about_z(sideways) * about_x(forward));
    }
    pose
}

/// Key times and poses `[key][bone]`: rolls up from the tip into a slanted coil and unrolls again.
fn curl() -> (Vec<f64>, Vec<Vec<DQuat>>) {
    let keys = 12_u32;
    (0..=keys)
        .map(|key| {
            let turn = f64::from(key) / f64::from(keys);
            let amount = 0.5 - 0.5 * cos_turn(turn);
            let pose = bent(|bone| {
                // The tip leads: its bones start to bend first, and bend most.
                let height = bone / BONE_COUNT as f64;
                let late = (1.6 * amount - 0.6 * (1.0 - height)).clamp(0.0, 1.0);
                (-late * (4.0 + 34.0 * height), late * 7.0 * height)
            });
            (4.0 * turn, pose)
        })
        .unzip()
}

/// Key times and poses `[key][bone]`: a wave that runs up the tentacle.
fn sway() -> (Vec<f64>, Vec<Vec<DQuat>>) {
    let keys = 8_u32;
    (0..=keys)
        .map(|key| {
            let turn = f64::from(key) / f64::from(keys);
            let pose = bent(|bone| {
                let phase = turn - bone / 20.0;
                (7.0 * sin_turn(phase), 3.5 * cos_turn(phase))
            });
            (3.0 * turn, pose)
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vertex_has_eight_influences_along_the_middle() {
        for height in [6.0, 11.25, 17.0] {
            let row = influences(height);
            assert_eq!(row.iter().filter(|(_, weight)| *weight > 0.0).count(), 8);
        }
    }

    #[test]
    fn surface_is_closed_and_outward() {
        let surface = surface();
        assert!(surface.is_closed_manifold());
        assert!(surface.volume() > 0.0);
    }
}
