use super::{
    cluster_morphs::MorphCover,
    levers,
    numbers::{index, index_within, reserved, solid_box, within_box},
    row,
    segments::Segment,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    geom::Aabb,
    rows::{ClusterRow, NONE, TriangleRow},
};
use std::ops::Range;

/// Checks that a cluster lists exactly the bones, in a segment of a cache the tracks, that move its vertices, with boxes
/// that contain all of these, and with a pose space levers too; and the same of its morph targets.
///
/// Run-time margins are computed from these rows alone: one that is missing or too small would lose hits.
pub(super) struct Cover<'a> {
    view: &'a ModelView<'a>,
    cluster: usize,
    /// Per bone or track, its row among the cluster's.
    row_of_mover: Vec<Option<usize>>,
    /// Per cluster-bone row, whether it moves a vertex.
    used: Vec<bool>,
    /// Per vertex, the last cluster that it was checked for, or `NONE`.
    checked_for: Vec<u32>,
    /// Per vertex, the last segment in which it was met, or `NONE`, and the box of its stored numbers there. Empty without
    /// caches.
    stored: Vec<(u32, Aabb)>,
    morphs: MorphCover<'a>,
}

impl<'a> Cover<'a> {
    pub(super) fn new(view: &'a ModelView<'a>) -> Self {
        Self {
            view,
            cluster: 0,
            row_of_mover: vec![None; view.bones.len().max(view.tracks.len())],
            used: vec![false; view.cluster_bones.len()],
            checked_for: vec![NONE; view.vertices.len()],
            stored: vec![(NONE, Aabb::EMPTY); if view.caches.is_empty() { 0 } else { view.vertices.len() }],
            morphs: MorphCover::new(view),
        }
    }

    /// Begins with cluster `at`, which is in `segment` if it has a track; its bones or tracks ascend.
    pub(super) fn enter(
        &mut self,
        at: usize,
        cluster: &ClusterRow,
        segment: Option<&Segment<'_>>,
    ) -> Result<(), FormatError> {
        self.cluster = at;
        let section = SectionKind::ClusterBones;
        let mut previous = None;
        for at in rows_of(cluster) {
            let listed = self.view.cluster_bones[at];
            let found = listed.bone;
            let mover = match segment {
                None => index(section, at, "bone", found, self.view.bones.len())?,
                Some(segment) => index_within(section, at, "bone", found, &segment.tracks())?,
            };
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
            reserved(section, at, "reserved", &[listed.reserved])?;
            solid_box(section, at, "bounds", &listed.bounds)?;
            self.row_of_mover[mover] = Some(at);
        }
        self.morphs.enter(at)
    }

    /// What moves the triangle's vertices is listed, with boxes that contain them.
    pub(super) fn triangle(
        &mut self,
        triangle: &TriangleRow,
        segment: Option<&Segment<'_>>,
    ) -> Result<(), FormatError> {
        for corner in triangle.corners {
            let vertex = corner as usize;
            if std::mem::replace(&mut self.checked_for[vertex], self.cluster as u32) == self.cluster as u32 {
                continue;
            }
            match segment {
                None => self.skinned_vertex(vertex)?,
                Some(segment) => self.cached_vertex(vertex, segment)?,
            }
        }
        Ok(())
    }

    fn skinned_vertex(&mut self, vertex: usize) -> Result<(), FormatError> {
        let view = self.view;
        let position = view.vertices[vertex].position_rest;
        for influence in view.influences_of(vertex) {
            let Some(at) = self.row_of_mover[influence.bone as usize] else {
                let fault = RowFault::ClusterBoneMissing {
                    bone: influence.bone,
                    vertex: vertex as u32,
                };
                return Err(row(SectionKind::Clusters, self.cluster, fault));
            };
            self.used[at] = true;
            let bounds = &view.cluster_bones[at].bounds;
            within_box(SectionKind::Vertices, vertex, "position_rest", position, bounds, at)?;
            let own = influence.bone == view.clusters[self.cluster].bone;
            if at < view.levers.len() && !own {
                levers::check_reach(view, at, vertex, influence.weight)?;
            }
        }
        self.morphs.vertex(vertex)
    }

    fn cached_vertex(&mut self, vertex: usize, segment: &Segment<'_>) -> Result<(), FormatError> {
        let view = self.view;
        let key_vertex = segment.key_vertex(vertex);
        let stored = &view.key_vertices[key_vertex];
        let Some(at) = self.row_of_mover[stored.track as usize] else {
            let fault = RowFault::ClusterTrackMissing {
                track: stored.track,
                vertex: vertex as u32,
            };
            return Err(row(SectionKind::Clusters, self.cluster, fault));
        };
        self.used[at] = true;
        let (met, own) = &mut self.stored[vertex];
        if *met != segment.at as u32 {
            *met = segment.at as u32;
            *own = stored.bounds(segment.keys(view));
        }
        let bounds = &view.cluster_bones[at].bounds;
        let (section, field) = (SectionKind::KeyVertices, "stored numbers");
        within_box(section, key_vertex, field, own.min, bounds, at)?;
        within_box(section, key_vertex, field, own.max, bounds, at)
    }

    /// Ends the cluster; everything that it lists has moved a vertex.
    pub(super) fn leave(&mut self, cluster: &ClusterRow) -> Result<(), FormatError> {
        for at in rows_of(cluster) {
            let mover = self.view.cluster_bones[at].bone;
            if !self.used[at] {
                let fault = match cluster.track {
                    NONE => RowFault::ClusterBoneUnused { bone: mover },
                    _ => RowFault::ClusterTrackUnused { track: mover },
                };
                return Err(row(SectionKind::ClusterBones, at, fault));
            }
            self.row_of_mover[mover as usize] = None;
        }
        self.morphs.leave()
    }
}

/// The cluster-bone rows of a cluster. Clusters have been checked.
pub(super) fn rows_of(cluster: &ClusterRow) -> Range<usize> {
    let first = cluster.cluster_bone_first as usize;
    first..first + cluster.cluster_bone_count as usize
}
