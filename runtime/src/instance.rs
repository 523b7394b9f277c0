use crate::{Aabb, Affine, asset_instance::AssetInstance, geometry_instance::GeometryInstance};

/// What a scene holds.
#[derive(Debug)]
pub(crate) enum Instance {
    Asset(Box<AssetInstance>),
    Geometry(Box<GeometryInstance>),
}

impl Instance {
    pub(crate) fn set_transform(&mut self, world_from_instance: Affine) {
        match self {
            Self::Asset(instance) => instance.transform = world_from_instance,
            Self::Geometry(instance) => instance.set_transform(world_from_instance),
        }
    }

    /// Prepares what rays need of it.
    pub(crate) fn update(&mut self) {
        match self {
            Self::Asset(instance) => instance.update(),
            Self::Geometry(instance) => instance.update(),
        }
    }

    /// World boxes of its clusters.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = Aabb> {
        let (clusters, geometry): (&[_], _) = match self {
            Self::Asset(instance) => (&instance.clusters, None),
            Self::Geometry(instance) => (&[], Some(instance.tree().bounds())),
        };
        clusters.iter().map(|active| active.frame.bounds_world).chain(geometry)
    }

    /// A posed vertex in world space; `None` without such a vertex.
    pub(crate) fn vertex(&self, vertex: u32) -> Option<[f32; 3]> {
        match self {
            Self::Asset(instance) => (vertex as usize + 1 < instance.asset.model().vertices.len())
                .then(|| instance.pose_vertex(instance.cache_of_vertex(vertex), vertex)),
            Self::Geometry(instance) => instance.posed_vertex(vertex),
        }
    }

    /// A posed triangle's corners in world space; `None` without such a triangle.
    pub(crate) fn triangle(&self, triangle: u32) -> Option<[[f32; 3]; 3]> {
        match self {
            Self::Asset(instance) => ((triangle as usize) < instance.asset.model().triangles.len())
                .then(|| instance.pose_triangle(instance.cache_of_triangle(triangle), triangle)),
            Self::Geometry(instance) => {
                ((triangle as usize) < instance.triangles().len()).then(|| instance.posed_triangle(triangle))
            }
        }
    }
}
