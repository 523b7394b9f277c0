use super::mesh::ObjMesh;
use crate::import::{Mesh, Part, Primitive};

/// One mesh and one part per group that has triangles, all on node 0, with the points that they use.
///
/// Shapes: `positions` has one entry per point of the OBJ file. `cache` is the vertex cache that moves the points.
pub(in crate::import) fn build(mesh: &ObjMesh, positions: &[[f32; 3]], cache: Option<usize>) -> (Vec<Mesh>, Vec<Part>) {
    let mut triangles: Vec<Vec<[u32; 3]>> = vec![Vec::new(); mesh.groups.len()];
    for (group, triangle) in mesh.triangles() {
        if let Some(list) = triangles.get_mut(group) {
            list.push(triangle);
        }
    }
    let mut vertex_of_point = vec![0; positions.len()];
    let (mut meshes, mut parts) = (Vec::new(), Vec::new());
    for (name, mut triangles) in mesh.groups.iter().zip(triangles) {
        if triangles.is_empty() {
            continue;
        }
        let points = number_vertices(&mut triangles, &mut vertex_of_point);
        let position = |point: &u32| positions.get(*point as usize).copied().unwrap_or_default();
        parts.push(Part {
            name: name.clone(),
            node: 0,
            mesh: meshes.len(),
            skin: None,
            cache,
        });
        meshes.push(Mesh {
            name: name.clone(),
            primitives: vec![Primitive {
                positions: points.iter().map(position).collect(),
                triangles,
                points: if cache.is_some() { points } else { Vec::new() },
                ..Primitive::default()
            }],
            morph_target_count: 0,
        });
    }
    (meshes, parts)
}

/// Makes the corners vertices instead of points, and gives the point of each vertex, ascending. `vertex_of_point` is
/// scratch, one entry per point.
fn number_vertices(triangles: &mut [[u32; 3]], vertex_of_point: &mut [u32]) -> Vec<u32> {
    let mut points = triangles.as_flattened().to_vec();
    points.sort_unstable();
    points.dedup();
    for (vertex, point) in (0u32..).zip(&points) {
        if let Some(entry) = vertex_of_point.get_mut(*point as usize) {
            *entry = vertex;
        }
    }
    for corner in triangles.as_flattened_mut() {
        *corner = vertex_of_point.get(*corner as usize).copied().unwrap_or_default();
    }
    points.shrink_to_fit();
    points
}
