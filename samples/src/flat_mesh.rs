//! Meshes without normals, whose faces viewers show flat, in each of glTF's triangle topologies.

use crate::column::{Column, Component};
use crate::gltf_json::{Mesh, Primitive, TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES};
use crate::gltf_writer::{GltfWriter, primitive};
use crate::solids::circle;
use crate::surface::Surface;
use glam::DVec3;

/// Adds a mesh.
pub fn add_mesh(writer: &mut GltfWriter, name: &str, primitives: Vec<Primitive>) -> usize {
    writer.add_mesh(Mesh {
        name: name.to_owned(),
        primitives,
        ..Mesh::default()
    })
}

/// Adds a mesh of one surface with 16-bit vertex numbers.
pub fn add_flat_mesh(writer: &mut GltfWriter, name: &str, surface: &Surface, material: usize) -> usize {
    let primitive = indexed(writer, surface, material, Component::U16);
    add_mesh(writer, name, vec![primitive])
}

/// A triangle list with vertex numbers that are at least as wide as `index_component`.
pub fn indexed(writer: &mut GltfWriter, surface: &Surface, material: usize, index_component: Component) -> Primitive {
    let indices = writer.add_indices(surface.triangles.as_flattened(), index_component);
    let mut primitive = unindexed(writer, &surface.positions, material, TRIANGLES);
    primitive.indices = Some(indices);
    primitive
}

/// A triangle list in which every triangle has its own three vertices.
pub fn soup(writer: &mut GltfWriter, surface: &Surface, material: usize) -> Primitive {
    let corners: Vec<_> = surface
        .triangles
        .as_flattened()
        .iter()
        .map(|&corner| surface.positions[corner as usize])
        .collect();
    unindexed(writer, &corners, material, TRIANGLES)
}

fn unindexed(writer: &mut GltfWriter, positions: &[DVec3], material: usize, mode: u32) -> Primitive {
    let attributes = writer.add_attributes(&[("POSITION", Column::vectors(positions))]);
    let mut primitive = primitive(attributes);
    primitive.material = Some(material);
    // Triangles are the default and are left out.
    primitive.mode = (mode != TRIANGLES).then_some(mode);
    primitive
}

/// A closed cylinder about y from -0.5 to 0.5: its side an indexed strip, its ends fans without vertex numbers.
pub fn cylinder(writer: &mut GltfWriter, radius: f64, sides: u32, material: usize) -> Vec<Primitive> {
    let (low, high) = (circle(radius, -0.5, sides), circle(radius, 0.5, sides));
    let ring: Vec<_> = low.iter().chain(&high).copied().collect();
    let strip: Vec<u32> = (0..=sides)
        .flat_map(|side| [sides + side % sides, side % sides])
        .collect();
    let mut side = unindexed(writer, &ring, material, TRIANGLE_STRIP);
    side.indices = Some(writer.add_indices(&strip, Component::U8));

    let fan = |y: f64, rim: Vec<DVec3>| {
        let first = rim.first().copied();
        let middle = core::iter::once(DVec3::new(0.0, y, 0.0));
        middle.chain(rim).chain(first).collect::<Vec<_>>()
    };
    let top = unindexed(writer, &fan(0.5, high), material, TRIANGLE_FAN);
    let reversed = low.into_iter().rev().collect();
    let bottom = unindexed(writer, &fan(-0.5, reversed), material, TRIANGLE_FAN);
    vec![side, top, bottom]
}
