use crate::{
    Asset, Hit, PoseError, asset_instance::AssetInstance, geometry_instance::GeometryInstance, instance::Instance,
};
use restpose_formats::{ModelView, rows::NONE};

/// What was hit, in the source's words.
///
/// Numbers are those of the source file; a triangle's number counts within its primitive, strips and fans unrolled. Of
/// geometry that the caller supplied there is no more to say than the triangle: rows and other numbers are `u32::MAX`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Part row of the asset; its name is in the metadata.
    pub part: u32,
    /// Node that shows the mesh.
    pub source_node: u32,
    /// Mesh.
    pub source_mesh: u32,
    /// Primitive of the mesh.
    pub source_primitive: u32,
    /// Triangle of the primitive.
    pub source_triangle: u32,
    /// Bone row with the greatest weight at the point, the lowest of equals; its name is in the metadata.
    pub bone: u32,
    /// The point, from the posed corners and the barycentric weights.
    pub position_world: [f32; 3],
    /// The same point of the surface in the rest pose, before any morph: where a decal goes. For supplied geometry, the
    /// point before the instance transform.
    pub position_rest: [f32; 3],
    /// Geometric normal of the posed triangle, counter-clockwise winding, at length one; zeros where it has no area. A
    /// mirrored bone turns the winding, and with it this normal.
    pub normal_world: [f32; 3],
}

impl SurfacePoint {
    /// Weights and normal in `f64`, rounded once. `pose` tells the corners of a triangle of an asset's instance, by the row of
    /// its cache and its own.
    pub(crate) fn new(
        hit: &Hit,
        instance: &Instance,
        pose: impl FnOnce(&AssetInstance, u32, u32) -> [[f32; 3]; 3],
    ) -> Result<Self, PoseError> {
        let count = match instance {
            Instance::Asset(instance) => instance.asset().model().triangles.len(),
            Instance::Geometry(instance) => instance.triangles().len(),
        };
        if hit.triangle as usize >= count {
            return Err(PoseError::UnknownTriangle {
                triangle: hit.triangle,
                count,
            });
        }
        Ok(match instance {
            Instance::Asset(instance) => {
                let cache = instance.asset().cache_of_triangle(hit.triangle);
                Self::of_asset(hit, instance.asset(), pose(instance, cache, hit.triangle))
            }
            Instance::Geometry(instance) => Self::of_geometry(hit, instance),
        })
    }

    fn of_geometry(hit: &Hit, instance: &GeometryInstance) -> Self {
        let corners = instance.posed_triangle(hit.triangle);
        let given = instance.triangles()[hit.triangle as usize]
            .corners
            .map(|corner| instance.position(corner));
        Self {
            part: NONE,
            source_node: NONE,
            source_mesh: NONE,
            source_primitive: NONE,
            source_triangle: hit.triangle,
            bone: NONE,
            position_world: blend(weights(hit), corners),
            position_rest: blend(weights(hit), given),
            normal_world: normal(corners),
        }
    }

    fn of_asset(hit: &Hit, asset: &Asset, corners: [[f32; 3]; 3]) -> Self {
        let model = asset.model();
        let part = model
            .parts
            .partition_point(|part| part.triangle_first <= hit.triangle)
            .saturating_sub(1);
        let part_row = &model.parts[part];
        let primitives = &model.primitives[part_row.primitive_first as usize..][..part_row.primitive_count as usize];
        let primitive = primitives
            .partition_point(|row| row.triangle_first <= hit.triangle)
            .saturating_sub(1);
        let primitive_row = &primitives[primitive];

        let rows = model.triangles[hit.triangle as usize]
            .corners
            .map(|corner| corner as usize);
        Self {
            part: part as u32,
            source_node: part_row.source_node,
            source_mesh: part_row.source_mesh,
            source_primitive: primitive_row.source_primitive,
            source_triangle: hit.triangle - primitive_row.triangle_first,
            bone: dominant_bone(model, rows, weights(hit)),
            position_world: blend(weights(hit), corners),
            position_rest: blend(weights(hit), rows.map(|row| model.vertices[row].position_rest)),
            normal_world: normal(corners),
        }
    }
}

/// Barycentric weights of the three corners.
fn weights(hit: &Hit) -> [f64; 3] {
    let (u, v) = (f64::from(hit.u), f64::from(hit.v));
    [1.0 - u - v, u, v]
}

fn blend(weights: [f64; 3], points: [[f32; 3]; 3]) -> [f32; 3] {
    std::array::from_fn(|k| (0..3).map(|i| weights[i] * f64::from(points[i][k])).sum::<f64>() as f32)
}

/// The bone with the greatest weight at the point. Quadratic in the influences of three vertices, which are few.
fn dominant_bone(model: &ModelView, rows: [usize; 3], weights: [f64; 3]) -> u32 {
    let weight_of = |bone: u32| -> f64 {
        (0..3)
            .flat_map(|i| model.influences_of(rows[i]).iter().map(move |influence| (i, influence)))
            .filter(|(_, influence)| influence.bone == bone)
            .map(|(i, influence)| weights[i] * f64::from(influence.weight))
            .sum()
    };
    let mut best = (NONE, f64::NEG_INFINITY);
    for bone in rows
        .iter()
        .flat_map(|row| model.influences_of(*row))
        .map(|influence| influence.bone)
    {
        let weight = weight_of(bone);
        if best.0 == NONE || weight > best.1 || (weight == best.1 && bone < best.0) {
            best = (bone, weight);
        }
    }
    best.0
}

fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let edge = |p: [f32; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(p[k]) - f64::from(a[k])) };
    let (e, f) = (edge(b), edge(c));
    let cross = [
        e[1] * f[2] - e[2] * f[1],
        e[2] * f[0] - e[0] * f[2],
        e[0] * f[1] - e[1] * f[0],
    ];
    let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        cross.map(|x| (x / length) as f32)
    } else {
        [0.0; 3]
    }
}
