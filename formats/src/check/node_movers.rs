use super::{cluster_bones::rows_of, numbers::index, row, tiling::Tiling};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, MAX_MOVERS, NONE, RestLattice, WideChild, WideNodeRow},
};
use std::ops::Range;

/// The movers of wide nodes fill their section; those of a node ascend, are bones that it can follow, and move nothing in
/// its empty places. Cluster ranges have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut ranges = Tiling::new(SectionKind::NodeMovers, view.node_movers.len());
    for cluster in view.clusters {
        let limit = mover_limit(view, cluster);
        let first = cluster.node_first as usize;
        for (at, node) in (first..).zip(&view.wide_nodes[first..][..cluster.node_count as usize]) {
            let (section, field) = (SectionKind::WideNodes, "mover_first");
            let rows = ranges.take(section, at, field, node.mover_first, node.mover_count)?;
            check_node(view, node, rows, limit)?;
        }
    }
    ranges.finish()
}

/// How many bones the nodes of a cluster can follow.
fn mover_limit(view: &ModelView<'_>, cluster: &ClusterRow) -> usize {
    let bones = &view.cluster_bones[rows_of(cluster)];
    if cluster.track != NONE || !RestLattice::new(bones).is_usable() {
        return 0;
    }
    let others = bones.iter().filter(|listed| listed.bone != cluster.bone);
    others.count().min(MAX_MOVERS)
}

fn check_node(view: &ModelView<'_>, node: &WideNodeRow, rows: Range<usize>, limit: usize) -> Result<(), FormatError> {
    let section = SectionKind::NodeMovers;
    let mut previous = None;
    for at in rows {
        let listed = view.node_movers[at];
        let found = listed.mover;
        index(section, at, "mover", found, limit)?;
        if let Some(previous) = previous
            && found <= previous
        {
            let fault = RowFault::NotAscending {
                field: "mover",
                found,
                previous,
            };
            return Err(row(section, at, fault));
        }
        previous = Some(found);
        let used = |place: usize| listed.weight[place] != 0 || listed.spread[place] != 0;
        let empty = |place: &usize| node.children[*place] == WideChild::EMPTY;
        if let Some(place) = (0..node.children.len()).filter(empty).find(|place| used(*place)) {
            return Err(row(section, at, RowFault::WeightOfEmptyPlace { place }));
        }
    }
    Ok(())
}
