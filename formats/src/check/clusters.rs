use super::{
    numbers::{index, reserved, solid_box},
    row,
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind, TreeKind,
    rows::{ClusterRow, NONE},
};

/// Clusters tile the nodes of the file's kind of trees, references and cluster bones, and have finite boxes; there are no
/// nodes of another kind. Bones have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::Clusters;
    check_other_trees(view)?;
    let mut nodes = match view.meta.tree {
        TreeKind::Kd => Tiling::new(SectionKind::KdNodes, view.kd_nodes.len()),
        TreeKind::Wide => Tiling::new(SectionKind::WideNodes, view.wide_nodes.len()),
    };
    let mut references = Tiling::new(SectionKind::References, view.references.len());
    let mut bones = Tiling::new(SectionKind::ClusterBones, view.cluster_bones.len());
    for (at, cluster) in view.clusters.iter().enumerate() {
        check_fields(view, at, cluster)?;
        nodes.take(section, at, "node_first", cluster.node_first, cluster.node_count)?;
        references.take(
            section,
            at,
            "reference_first",
            cluster.reference_first,
            cluster.reference_count,
        )?;
        bones.take(
            section,
            at,
            "cluster_bone_first",
            cluster.cluster_bone_first,
            cluster.cluster_bone_count,
        )?;
    }
    nodes.finish()?;
    references.finish()?;
    bones.finish()
}

fn check_other_trees(view: &ModelView<'_>) -> Result<(), FormatError> {
    let tree = view.meta.tree;
    let counts: &[(SectionKind, usize)] = match tree {
        TreeKind::Kd => &[
            (SectionKind::WideNodes, view.wide_nodes.len()),
            (SectionKind::NodeMovers, view.node_movers.len()),
            (SectionKind::KeyBoxes, view.key_boxes.len()),
        ],
        TreeKind::Wide => &[
            (SectionKind::KdNodes, view.kd_nodes.len()),
            (SectionKind::ReferenceBoxes, view.reference_boxes.len()),
        ],
    };
    match counts.iter().find(|(_, count)| *count != 0) {
        Some(&(section, found)) => Err(FormatError::RowsOfOtherTrees {
            section,
            found: found as u64,
            tree,
        }),
        None => Ok(()),
    }
}

fn check_fields(view: &ModelView<'_>, at: usize, cluster: &ClusterRow) -> Result<(), FormatError> {
    let section = SectionKind::Clusters;
    reserved(section, at, "reserved", &[cluster.reserved])?;
    index(section, at, "bone", cluster.bone, view.bones.len())?;
    if cluster.node_count == 0 && cluster.track == NONE {
        return Err(row(section, at, RowFault::EmptyRange { field: "node_count" }));
    }
    solid_box(section, at, "bounds_local", &cluster.bounds_local)
}
