//! `mixed.glb`: static ground, a skinned creature, a rigid propeller, a morphing blob, a flower that morphs under a skin.

use crate::column::{Column, Component, narrow, narrow_rotation, narrow3};
use crate::creature::{add_creature, prowl};
use crate::flat_mesh::{add_flat_mesh, add_mesh, indexed};
use crate::flower::{add_flower, bloom, nod};
use crate::gltf_json::{Mesh, MeshExtras, Node};
use crate::gltf_writer::{GltfWriter, Track, WriteError, primitive, with_tangents};
use crate::rotation::{about_y, about_z, cos_turn, sin_turn};
use crate::solids::{cuboid, lathe, loft, sphere};
use crate::surface::Surface;
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;

/// The scene's bytes.
///
/// # Errors
/// [`WriteError`] as [`GltfWriter::into_glb`] says.
pub fn mixed_glb() -> Result<Vec<u8>, WriteError> {
    let mut writer = GltfWriter::new("mixed");
    let stone = writer.add_material("stone", [0.5, 0.48, 0.43]);
    let fur = writer.add_material("fur", [0.62, 0.4, 0.18]);
    let petal = writer.add_material("petal", [0.75, 0.25, 0.4]);
    let jelly = writer.add_material("jelly", [0.2, 0.5, 0.55]);
    let metal = writer.add_material("metal", [0.55, 0.57, 0.6]);

    add_ground(&mut writer, stone);
    let placed = |name: &str, place: [f32; 3], turn_deg: f64, scale: Option<[f32; 3]>| Node {
        name: name.to_owned(),
        translation: Some(place),
        rotation: Some(narrow_rotation(about_y(turn_deg))),
        scale,
        ..Node::default()
    };
    let armature = placed("creature", [0.0, 0.0, 0.5], 35.0, Some([1.25; 3]));
    let creature = add_creature(&mut writer, armature, fur);
    let armature = placed("flower", [1.45, 0.0, 0.9], -20.0, None);
    let flower = add_flower(&mut writer, armature, petal);
    let blob = add_blob(&mut writer, jelly);
    let propeller = add_windmill(&mut writer, metal);

    let mut bustle = prowl(&creature);
    bustle.extend(bloom(&flower, 2.0));
    bustle.push(wobble(blob));
    bustle.push(spin(propeller, 2.0, 2));
    writer.add_clip("bustle", &bustle);

    let mut breeze = nod(&flower.skeleton, 4.0, 4.0);
    breeze.push(spin(propeller, 4.0, 1));
    writer.add_clip("breeze", &breeze);
    writer.into_glb()
}

/// Slab, steps, blocks and an arch in one mesh, its positions quantised to sixteen bits.
fn add_ground(writer: &mut GltfWriter, material: usize) {
    writer.require_extension("KHR_mesh_quantization");
    let block = |low: [f64; 3], high: [f64; 3]| cuboid(DVec3::from(low), DVec3::from(high));
    let blocks = [
        block([-2.5, -0.2, -2.0], [2.5, 0.0, 2.0]),
        // Steps at the back left.
        block([-2.3, 0.0, -1.9], [-0.7, 0.2, -0.4]),
        block([-2.3, 0.2, -1.9], [-0.7, 0.4, -0.9]),
        block([-2.3, 0.4, -1.9], [-0.7, 0.6, -1.4]),
        // An arch at the back right.
        block([0.6, 0.0, -1.7], [0.9, 1.2, -1.3]),
        block([1.7, 0.0, -1.7], [2.0, 1.2, -1.3]),
        block([0.5, 1.2, -1.75], [2.1, 1.45, -1.25]),
        // Loose blocks.
        block([-2.2, 0.0, 1.0], [-1.7, 0.5, 1.5]),
        block([-1.6, 0.0, 1.3], [-1.3, 0.3, 1.6]),
        block([2.0, 0.0, -0.2], [2.3, 0.8, 0.1]),
    ];
    let mut ground = Surface::default();
    for block in &blocks {
        ground.append(block);
    }
    // Stored in steps of a twentieth of a unit over a node scale: every corner lies on a step.
    let steps_per_unit = 20.0;
    let rows: Vec<[i64; 3]> = ground
        .positions
        .iter()
        .map(|point| point.to_array().map(|value| libm::round(value * steps_per_unit) as i64))
        .collect();
    let positions = Column::integers(Component::I16, false, &rows);
    let mut primitive = primitive(writer.add_attributes(&[("POSITION", positions)]));
    primitive.indices = Some(writer.add_indices(ground.triangles.as_flattened(), Component::U8));
    primitive.material = Some(material);
    let mesh = add_mesh(writer, "ground", vec![primitive]);
    writer.add_root(Node {
        name: "ground".to_owned(),
        mesh: Some(mesh),
        scale: Some([narrow(1.0 / steps_per_unit); 3]),
        ..Node::default()
    });
}

const BLOB_RADIUS: f64 = 0.42;

/// A ball on the steps with two morph targets; the second, three horns, is stored sparsely.
fn add_blob(writer: &mut GltfWriter, material: usize) -> usize {
    let ball = sphere(3).map(|point| point * BLOB_RADIUS);
    let squash = |point: DVec3| {
        let height = point.y + BLOB_RADIUS;
        let wider = 1.35 - 0.2 * height / BLOB_RADIUS;
        DVec3::new(point.x * wider, height * 0.55 - BLOB_RADIUS, point.z * wider)
    };
    let horns = [0.0, 120.0, 240.0].map(|turn| about_y(turn) * DVec3::new(0.6, 0.8, 0.0));
    let horned = |point: DVec3| {
        let direction = point.normalize();
        let reach = horns.map(|horn| (direction.dot(horn) - 0.88).max(0.0) / 0.12);
        point * (1.0 + 0.7 * reach.iter().map(|reach| reach * reach).sum::<f64>())
    };

    let attributes = writer.add_attributes(&[("POSITION", Column::vectors(&ball.positions))]);
    let mut primitive = primitive(attributes);
    primitive.indices = Some(writer.add_indices(ball.triangles.as_flattened(), Component::U16));
    primitive.material = Some(material);
    let moved = |target: &dyn Fn(DVec3) -> DVec3| -> Vec<DVec3> {
        let moves = ball.positions.iter().map(|&point| target(point) - point);
        moves.collect()
    };
    let dense = [("POSITION", Column::vectors(&moved(&squash)))];
    primitive.targets.push(writer.add_attributes(&dense));
    let sparse: Vec<_> = moved(&horned).into_iter().map(narrow3).collect();
    let sparse = writer.add_sparse_displacements(&sparse);
    primitive
        .targets
        .push(BTreeMap::from([("POSITION".to_owned(), sparse)]));
    let mesh = writer.add_mesh(Mesh {
        name: "blob".to_owned(),
        primitives: vec![primitive],
        // The node has weights of its own.
        weights: Vec::new(),
        extras: Some(MeshExtras {
            target_names: vec!["squash".to_owned(), "horns".to_owned()],
        }),
    });
    writer.add_root(Node {
        name: "blob".to_owned(),
        mesh: Some(mesh),
        translation: Some(narrow3(DVec3::new(-1.5, 0.6 + BLOB_RADIUS, -1.3))),
        weights: vec![0.2, 0.5],
        ..Node::default()
    })
}

fn wobble(blob: usize) -> Track {
    let times = [0.0, 0.5, 1.0, 1.5, 2.0];
    let weights = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.7, 0.5], [0.0, 0.0]];
    let rows = with_tangents(&times, &weights);
    let scalars: Vec<[f32; 1]> = rows.into_iter().flatten().map(|value| [value]).collect();
    Track {
        node: blob,
        path: "weights",
        interpolation: "CUBICSPLINE",
        times: times.to_vec(),
        values: Column::floats(&scalars),
    }
}

/// A mast whose node has a matrix, and on its top the propeller that turns.
fn add_windmill(writer: &mut GltfWriter, material: usize) -> usize {
    let mast = lathe(&[(0.14, 0.0), (0.1, 0.1), (0.05, 1.6), (0.08, 1.62), (0.08, 1.78)], 16);
    let mast = add_flat_mesh(writer, "mast", &mast, material);
    let place = DVec3::new(-0.1, 0.0, -1.2);
    let matrix = DMat4::from_rotation_translation(about_y(18.0) * about_z(-4.0), place);
    let mast = writer.add_root(Node {
        name: "mast".to_owned(),
        mesh: Some(mast),
        matrix: Some(matrix.to_cols_array().map(narrow)),
        ..Node::default()
    });
    let blades: Vec<_> = [0.0, 120.0, 240.0]
        .map(|turn| blade().map(|point| about_z(turn) * point))
        .to_vec();
    let hub = lathe(&[(0.09, -0.1), (0.1, 0.04), (0.07, 0.12), (0.02, 0.15)], 16)
        .map(|point| DVec3::new(point.x, -point.z, point.y));
    let mut surface = hub;
    for blade in &blades {
        surface.append(blade);
    }
    let propeller = indexed(writer, &surface, material, Component::U16);
    let mesh = add_mesh(writer, "propeller", vec![propeller]);
    writer.add_child(
        mast,
        Node {
            name: "propeller".to_owned(),
            mesh: Some(mesh),
            translation: Some([0.0, 1.7, 0.18]),
            ..Node::default()
        },
    )
}

/// A blade along +y, twisted from steep to flat.
fn blade() -> Surface {
    let sections = 10_u32;
    let rings: Vec<Vec<DVec3>> = (0..=sections)
        .map(|section| {
            let along = f64::from(section) / f64::from(sections);
            let width = 0.05 + 0.09 * sin_turn(0.1 + 0.36 * along);
            let turned = about_y(55.0 - 40.0 * along);
            let outline = (0..12_u32).map(|step| {
                let turn = f64::from(step) / 12.0;
                let flat = DVec3::new(width * sin_turn(turn), 0.0, 0.018 * cos_turn(turn));
                turned * flat + DVec3::Y * (0.04 + 0.75 * along)
            });
            outline.collect()
        })
        .collect();
    loft(&rings)
}

/// `turns` whole turns in `seconds`, six keys to the turn.
fn spin(node: usize, seconds: f64, turns: u32) -> Track {
    let keys = 6 * turns;
    let times: Vec<_> = (0..=keys)
        .map(|key| seconds * f64::from(key) / f64::from(keys))
        .collect();
    let rotations: Vec<_> = (0..=keys).map(|key| about_z(60.0 * f64::from(key))).collect();
    Track {
        node,
        path: "rotation",
        interpolation: "LINEAR",
        times,
        values: Column::rotations(&rotations),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blade_is_closed_and_outward() {
        assert!(blade().is_closed_manifold());
        assert!(blade().volume() > 0.0);
    }
}
