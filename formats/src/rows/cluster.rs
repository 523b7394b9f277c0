use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// A cluster: triangles that move together, and the fuzzy tree over them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterRow {
    /// Bone whose `X` is the cluster frame; where there is a track, `X` times the track's map is.
    pub bone: u32,
    /// First node row of its tree, the root, in the section of the file's [kind of trees](crate::TreeKind).
    pub node_first: u32,
    /// Node rows of its tree; none in free motion.
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
    /// frame to the next, and none is stored.
    pub track: u32,
    /// Zero.
    pub reserved: u32,
}

/// A bone, or in a cluster with a track a track, that moves vertices of a cluster, and where these lie in the space that it
/// maps from.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterBoneRow {
    /// Bone row; track row in a cluster with a track.
    pub bone: u32,
    /// Contains the rest positions of the cluster's vertices that this bone moves. For a track, it contains their
    /// [stored numbers](super::KeyVertexRow::bounds) at all keys of the segment.
    pub bounds: Aabb,
    /// Zero.
    pub reserved: u32,
}

impl ClusterBoneRow {
    /// Largest magnitude in the box, per axis.
    #[inline]
    #[must_use]
    pub fn extent(&self) -> [f32; 3] {
        std::array::from_fn(|k| self.bounds.min[k].abs().max(self.bounds.max[k].abs()))
    }
}
