use super::{
    numbers::{extent, index, within_extent},
    row,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, NONE, TriangleRow},
};

/// Checks that a cluster lists exactly the bones that move its vertices, with extents that reach all of these.
///
/// Run-time margins are computed from these rows alone: one that is missing or too small would lose hits.
pub(super) struct Cover<'a> {
    view: &'a ModelView<'a>,
    cluster: usize,
    /// Per bone, its row among the cluster's.
    row_of_bone: Vec<Option<usize>>,
    /// Per cluster-bone row, whether its bone moves a vertex.
    used: Vec<bool>,
    /// Per vertex, the last cluster that it was checked for, or `NONE`.
    checked_for: Vec<u32>,
}

impl<'a> Cover<'a> {
    pub(super) fn new(view: &'a ModelView<'a>) -> Self {
        Self {
            view,
            cluster: 0,
            row_of_bone: vec![None; view.bones.len()],
            used: vec![false; view.cluster_bones.len()],
            checked_for: vec![NONE; view.vertices.len()],
        }
    }

    /// Begins with cluster `at`; its bones ascend.
    pub(super) fn enter(&mut self, at: usize, cluster: &ClusterRow) -> Result<(), FormatError> {
        self.cluster = at;
        let section = SectionKind::ClusterBones;
        let mut previous = None;
        for at in bone_rows(cluster) {
            let listed = self.view.cluster_bones[at];
            let found = listed.bone;
            let bone = index(section, at, "bone", found, self.row_of_bone.len())?;
            if let Some(previous) = previous
                && found <= previous
            {
                let fault = RowFault::NotAscending {
                    field: "bone",
                    found,
                    previous,
                };
                return Err(row(section, at, fault));
            }
            previous = Some(found);
            extent(section, at, "extent", &listed.extent)?;
            self.row_of_bone[bone] = Some(at);
        }
        Ok(())
    }

    /// The bones that move the triangle's vertices are listed, with extents that reach them.
    pub(super) fn triangle(&mut self, triangle: &TriangleRow) -> Result<(), FormatError> {
        for corner in triangle.corners {
            let vertex = corner as usize;
            if std::mem::replace(&mut self.checked_for[vertex], self.cluster as u32) != self.cluster as u32 {
                self.vertex(vertex)?;
            }
        }
        Ok(())
    }

    fn vertex(&mut self, vertex: usize) -> Result<(), FormatError> {
        let view = self.view;
        let position = view.vertices[vertex].position_rest;
        let first = view.vertices[vertex].influence_first as usize;
        let end = view.vertices[vertex + 1].influence_first as usize;
        for influence in &view.influences[first..end] {
            let Some(at) = self.row_of_bone[influence.bone as usize] else {
                let fault = RowFault::ClusterBoneMissing {
                    bone: influence.bone,
                    vertex: vertex as u32,
                };
                return Err(row(SectionKind::Clusters, self.cluster, fault));
            };
            self.used[at] = true;
            let reach = view.cluster_bones[at].extent;
            within_extent(SectionKind::Vertices, vertex, "position_rest", position, reach, at)?;
        }
        Ok(())
    }

    /// Ends the cluster; every bone that it lists has moved a vertex.
    pub(super) fn leave(&mut self, cluster: &ClusterRow) -> Result<(), FormatError> {
        for at in bone_rows(cluster) {
            let bone = self.view.cluster_bones[at].bone;
            if !self.used[at] {
                return Err(row(SectionKind::ClusterBones, at, RowFault::ClusterBoneUnused { bone }));
            }
            self.row_of_bone[bone as usize] = None;
        }
        Ok(())
    }
}

fn bone_rows(cluster: &ClusterRow) -> std::ops::Range<usize> {
    let first = cluster.cluster_bone_first as usize;
    first..first + cluster.cluster_bone_count as usize
}
