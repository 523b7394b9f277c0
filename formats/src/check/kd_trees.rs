use super::{numbers::finite, row};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, KdNode, MAX_KD_DEPTH},
};

/// Marks a node that no node before it has as a child.
const UNREACHED: u8 = u8::MAX;

/// Every cluster's nodes form one kd-tree, rooted in its first node, and its leaves share out its references. Cluster
/// ranges, and that clusters in free motion alone have no nodes, have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    // Inner nodes above each node.
    let mut depths = vec![UNREACHED; view.kd_nodes.len()];
    let mut held = vec![false; view.references.len()];
    for cluster in view.clusters {
        check_tree(view, cluster, &mut depths, &mut held)?;
    }
    match held.iter().position(|held| !held) {
        Some(at) => Err(row(SectionKind::References, at, RowFault::ReferenceUnused)),
        None => Ok(()),
    }
}

fn check_tree(
    view: &ModelView<'_>,
    cluster: &ClusterRow,
    depths: &mut [u8],
    held: &mut [bool],
) -> Result<(), FormatError> {
    let first = cluster.node_first as usize;
    let nodes = first..first + cluster.node_count as usize;
    let first_reference = cluster.reference_first as usize;
    let held = &mut held[first_reference..first_reference + cluster.reference_count as usize];
    let depths = &mut depths[nodes.clone()];
    match depths.first_mut() {
        Some(root) => *root = 0,
        // In free motion references are a list, of which no tree holds a part.
        None => held.fill(true),
    }
    // Children stand behind their parents, so one pass meets every parent first.
    for (own, node) in view.kd_nodes[nodes].iter().enumerate() {
        let at = first + own;
        let fail = |fault| row(SectionKind::KdNodes, at, fault);
        let depth = depths[own];
        if depth == UNREACHED {
            return Err(fail(RowFault::NoParent));
        }
        match node.unpack() {
            KdNode::Inner { axis: _, split, left } => {
                finite(SectionKind::KdNodes, at, "split", &[split])?;
                let found = depth as usize + 1;
                if found > MAX_KD_DEPTH {
                    return Err(fail(RowFault::TooDeep {
                        found,
                        limit: MAX_KD_DEPTH,
                    }));
                }
                if left as usize <= own {
                    return Err(fail(RowFault::ChildNotBehind {
                        found: left,
                        own: own as u32,
                    }));
                }
                for child in [left, left + 1] {
                    let Some(child_depth) = depths.get_mut(child as usize) else {
                        return Err(fail(RowFault::IndexOutOfRange {
                            field: "child",
                            found: u64::from(child),
                            limit: u64::from(cluster.node_count),
                        }));
                    };
                    if *child_depth != UNREACHED {
                        return Err(fail(RowFault::TwoParents { child }));
                    }
                    *child_depth = found as u8;
                }
            }
            KdNode::Leaf { first, count } => {
                hold(held, first, count).map_err(fail)?;
            }
        }
    }
    Ok(())
}

/// Marks a leaf's references as held.
fn hold(held: &mut [bool], first: u32, count: u32) -> Result<(), RowFault> {
    let limit = held.len() as u64;
    let end = u64::from(first) + u64::from(count);
    let Some(leaf) = held.get_mut(first as usize..end as usize) else {
        let (first, count) = (u64::from(first), u64::from(count));
        return Err(RowFault::RangeOutOfBounds {
            field: "reference",
            first,
            count,
            limit,
        });
    };
    for (reference, held) in (first..).zip(leaf) {
        if std::mem::replace(held, true) {
            return Err(RowFault::ReferenceShared { reference });
        }
    }
    Ok(())
}
