use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// A cluster: the triangles that one bone carries, and the fuzzy tree over them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterRow {
    /// Bone whose `X` is the cluster frame.
    pub bone: u32,
    /// First node row of its tree, the root.
    pub node_first: u32,
    /// Node rows of its tree.
    pub node_count: u32,
    /// First row in the reference section.
    pub reference_first: u32,
    /// Reference rows of its tree.
    pub reference_count: u32,
    /// First cluster-bone row.
    pub cluster_bone_first: u32,
    /// Cluster-bone rows: the bones that move vertices of this cluster.
    pub cluster_bone_count: u32,
    /// Triangles in the cluster, each counted once.
    pub triangle_count: u32,
    /// Box around all of its fuzzy boxes, in the cluster's local space.
    pub bounds_local: Aabb,
    /// Zero.
    pub reserved: [u32; 2],
}

/// A bone that moves vertices of a cluster, and how far from the origin of rest space those vertices lie.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterBoneRow {
    /// Bone row.
    pub bone: u32,
    /// Largest `|position_rest|` per axis over the cluster's vertices that this bone moves.
    pub extent: [f32; 3],
}
