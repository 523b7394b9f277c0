use super::{
    numbers::{extent, index},
    row,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterMorphRow, MorphDeltaRow},
};
use std::ops::Range;

/// Checks that a cluster with a pose space lists exactly the morph targets that displace its vertices, with extents that
/// reach all of these displacements. Does nothing for a cluster without one.
pub(super) struct MorphCover<'a> {
    view: &'a ModelView<'a>,
    cluster: usize,
    /// Per morph target, its row among the cluster's. Empty without pose spaces.
    row_of_target: Vec<Option<usize>>,
    /// Per cluster-morph row, whether it displaces a vertex.
    used: Vec<bool>,
}

impl<'a> MorphCover<'a> {
    pub(super) fn new(view: &'a ModelView<'a>) -> Self {
        let targets = if view.pose_spaces.is_empty() {
            0
        } else {
            view.morph_targets.len()
        };
        Self {
            view,
            cluster: 0,
            row_of_target: vec![None; targets],
            used: vec![false; view.cluster_morphs.len()],
        }
    }

    /// Begins with cluster `at`; its targets ascend.
    pub(super) fn enter(&mut self, at: usize) -> Result<(), FormatError> {
        self.cluster = at;
        let section = SectionKind::ClusterMorphs;
        let mut previous = None;
        for at in self.rows() {
            let ClusterMorphRow {
                target: found,
                extent: e,
            } = self.view.cluster_morphs[at];
            let target = index(section, at, "target", found, self.row_of_target.len())?;
            if let Some(previous) = previous
                && found <= previous
            {
                let field = "target";
                return Err(row(section, at, RowFault::NotAscending { field, found, previous }));
            }
            previous = Some(found);
            extent(section, at, "extent", &e)?;
            self.row_of_target[target] = Some(at);
        }
        Ok(())
    }

    /// What displaces the vertex is listed, with extents that reach as far.
    pub(super) fn vertex(&mut self, vertex: usize) -> Result<(), FormatError> {
        if self.view.pose_spaces.get(self.cluster).is_none() {
            return Ok(());
        }
        for MorphDeltaRow { target, delta } in self.view.morph_deltas_of(vertex) {
            let Some(at) = self.row_of_target[*target as usize] else {
                let (target, vertex) = (*target, vertex as u32);
                let fault = RowFault::ClusterMorphMissing { target, vertex };
                return Err(row(SectionKind::Clusters, self.cluster, fault));
            };
            self.used[at] = true;
            self.reach(at, vertex, delta)?;
        }
        Ok(())
    }

    fn reach(&self, at: usize, vertex: usize, delta: &[f32; 3]) -> Result<(), FormatError> {
        let reach = self.view.cluster_morphs[at].extent;
        for (axis, field) in ["extent[0]", "extent[1]", "extent[2]"].into_iter().enumerate() {
            if delta[axis].abs() > reach[axis] {
                let fault = RowFault::TooSmall {
                    field,
                    found: reach[axis],
                    least: f64::from(delta[axis].abs()),
                    vertex: vertex as u32,
                };
                return Err(row(SectionKind::ClusterMorphs, at, fault));
            }
        }
        Ok(())
    }

    /// Ends the cluster; every target that it lists has displaced a vertex.
    pub(super) fn leave(&mut self) -> Result<(), FormatError> {
        for at in self.rows() {
            let target = self.view.cluster_morphs[at].target;
            if !self.used[at] {
                let fault = RowFault::ClusterMorphUnused { target };
                return Err(row(SectionKind::ClusterMorphs, at, fault));
            }
            self.row_of_target[target as usize] = None;
        }
        Ok(())
    }

    fn rows(&self) -> Range<usize> {
        match self.view.pose_spaces.get(self.cluster) {
            Some(space) => {
                let first = space.morph_first as usize;
                first..first + space.morph_count as usize
            }
            None => 0..0,
        }
    }
}
