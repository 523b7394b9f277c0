use crate::{Aabb, Affine, asset_instance::AssetInstance, geometry_instance::GeometryInstance, simd::Portable};

/// What a scene holds.
#[derive(Debug)]
pub(crate) enum Instance {
    Asset(Box<AssetInstance>),
    Geometry(Box<GeometryInstance>),
}

impl Instance {
    pub(crate) fn set_transform(&mut self, world_from_instance: Affine) {
        match self {
            Self::Asset(instance) => instance.state.transform = world_from_instance,
            Self::Geometry(instance) => instance.set_transform(world_from_instance),
        }
    }

    /// Prepares what must be there before rays come, in the state that it has now.
    pub(crate) fn update(&mut self) {
        match self {
            Self::Asset(instance) => instance.update(),
            Self::Geometry(instance) => instance.update(),
        }
    }

    /// Contains every posed vertex that some triangle with area uses, as of the last update.
    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Asset(instance) => *instance.bounds(),
            Self::Geometry(instance) => instance.bounds(),
        }
    }

    /// A posed vertex in world space; `None` without such a vertex.
    pub(crate) fn vertex(&self, vertex: u32) -> Option<[f32; 3]> {
        match self {
            Self::Asset(instance) => {
                let asset = instance.asset();
                (vertex as usize + 1 < asset.model().vertices.len()).then(|| {
                    let cache = asset.cache_of_vertex(vertex);
                    instance
                        .prepared()
                        .recomputed_vertex(Portable, asset.model(), cache, vertex)
                })
            }
            Self::Geometry(instance) => instance.posed_vertex(vertex),
        }
    }

    /// All posed vertices in world space, in place of what is in `out`.
    pub(crate) fn vertices(&self, out: &mut Vec<[f32; 3]>) {
        match self {
            Self::Asset(instance) => instance.prepared().pose_all(instance.asset(), out),
            Self::Geometry(instance) => {
                out.clear();
                out.extend_from_slice(instance.posed_vertices());
            }
        }
    }

    /// A posed triangle's corners in world space; `None` without such a triangle.
    pub(crate) fn triangle(&self, triangle: u32) -> Option<[[f32; 3]; 3]> {
        match self {
            Self::Asset(instance) => {
                let asset = instance.asset();
                ((triangle as usize) < asset.model().triangles.len()).then(|| {
                    let cache = asset.cache_of_triangle(triangle);
                    instance.prepared().recomputed_triangle(asset.model(), cache, triangle)
                })
            }
            Self::Geometry(instance) => {
                ((triangle as usize) < instance.triangles().len()).then(|| instance.posed_triangle(triangle))
            }
        }
    }
}
