use crate::{
    Aabb, Affine, PoseError,
    box_tree::{BoxTree, triangle_box},
    posed_mesh::{PosedMesh, corners},
    posed_tree::PosedTree,
};
use restpose_formats::rows::{TriangleRow, WideChild};

/// Vertices that one task poses.
#[cfg(feature = "parallel")]
const VERTICES_PER_TASK: usize = 4096;

/// Triangles that the caller supplies, anew as often as it likes, and the tree over them.
#[derive(Debug, Default)]
pub(crate) struct GeometryInstance {
    transform: Affine,
    positions: Vec<[f32; 3]>,
    triangles: Vec<TriangleRow>,
    /// World space, as of the last commit.
    posed: Vec<[f32; 3]>,
    tree: PosedTree,
    is_changed: bool,
}

impl GeometryInstance {
    pub(crate) fn set_transform(&mut self, world_from_geometry: Affine) {
        self.is_changed |= self.transform != world_from_geometry;
        self.transform = world_from_geometry;
    }

    /// Replaces all triangles.
    pub(crate) fn set(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), PoseError> {
        let count = triangles.len();
        if count > Self::MAX_TRIANGLES {
            return Err(PoseError::TooManyTriangles {
                count,
                most: Self::MAX_TRIANGLES,
            });
        }
        if let Some(vertex) = positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(PoseError::VertexNotFinite { vertex });
        }
        let vertices = positions.len();
        let unknown = |triangle: &[u32; 3]| triangle.iter().find(|corner| **corner as usize >= vertices).copied();
        if let Some((triangle, corner)) = triangles.iter().enumerate().find_map(|(i, t)| Some((i, unknown(t)?))) {
            return Err(PoseError::CornerOutOfRange {
                triangle,
                corner,
                vertices,
            });
        }
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.triangles.clear();
        self.triangles
            .extend(triangles.iter().map(|corners| TriangleRow { corners: *corners }));
        self.is_changed = true;
        Ok(())
    }

    /// What the indices of wide trees count, which are fewer than those of binary ones.
    const MAX_TRIANGLES: usize = WideChild::MAX_INDEX as usize + 1;

    /// Poses all vertices and builds the tree, where something has changed since.
    pub(crate) fn update(&mut self) {
        if !std::mem::take(&mut self.is_changed) {
            return;
        }
        let transform = self.transform;
        let pose = |position: &[f32; 3]| transform.transform_point(*position);
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let tasks = self.positions.par_iter().with_min_len(VERTICES_PER_TASK);
            tasks.map(pose).collect_into_vec(&mut self.posed);
        }
        #[cfg(not(feature = "parallel"))]
        {
            self.posed.clear();
            self.posed.extend(self.positions.iter().map(pose));
        }
        let (posed, triangles) = (&self.posed, &self.triangles);
        let bound = |triangle| triangle_box(corners(triangles, posed, triangle));
        self.tree.rebuild(0..triangles.len() as u32, bound);
    }

    /// Counts rays that enter.
    #[inline]
    pub(crate) fn count(&self, rays: u32) {
        self.tree.count(rays);
    }

    /// Its triangles as of the last commit, where the wide tree over them pays and is there.
    #[inline]
    pub(crate) fn mesh(&self) -> Option<PosedMesh<'_>> {
        Some(PosedMesh {
            nodes: self.tree.wide()?,
            triangles: &self.triangles,
            positions: &self.posed,
        })
    }

    /// The other tree over them.
    pub(crate) fn binary_tree(&self) -> &BoxTree {
        self.tree.binary()
    }

    /// Box around everything; empty where there is nothing.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    pub(crate) fn triangles(&self) -> &[TriangleRow] {
        &self.triangles
    }

    /// A vertex as it was given.
    pub(crate) fn position(&self, vertex: u32) -> [f32; 3] {
        self.positions[vertex as usize]
    }

    /// World space.
    pub(crate) fn posed_vertices(&self) -> &[[f32; 3]] {
        &self.posed
    }

    /// World space; `None` without such a vertex.
    pub(crate) fn posed_vertex(&self, vertex: u32) -> Option<[f32; 3]> {
        self.posed.get(vertex as usize).copied()
    }

    /// World space.
    #[inline]
    pub(crate) fn posed_triangle(&self, triangle: u32) -> [[f32; 3]; 3] {
        corners(&self.triangles, &self.posed, triangle)
    }
}
