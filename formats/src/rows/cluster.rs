use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// A cluster: triangles that move together, and the fuzzy tree over them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterRow {
    /// Bone whose `X` is the cluster frame; where there is a track, `X` times the track's map is.
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
    /// Track row that moves it against its bone, or `NONE`. A track without keys marks free motion: no tree holds from one
    /// frame to the next, and the stored one is a single leaf.
    pub track: u32,
    /// Zero.
    pub reserved: u32,
}

/// A bone, or in a cluster with a track a track, that moves vertices of a cluster, and how far these lie from the origin of
/// the space that it maps from.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterBoneRow {
    /// Bone row; track row in a cluster with a track.
    pub bone: u32,
    /// Largest `|position_rest|` per axis over the cluster's vertices that this bone moves. For a track, at least the
    /// largest stored number: `max(|base|, |base + 2^width − 1|)`, or that of its raw positions.
    pub extent: [f32; 3],
}
