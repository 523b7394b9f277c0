use super::row;
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, MAX_WIDE_DEPTH, WideChild, WideNodeRow},
};

/// Every cluster's nodes form one wide tree, rooted in its first node, with boxes inside of boxes of their kind, whose
/// leaves name the cluster's triangles as its references do. Cluster ranges, and that clusters in free motion alone have
/// no nodes, have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut places = vec![None; view.wide_nodes.len()];
    for (at, cluster) in view.clusters.iter().enumerate() {
        if cluster.reference_count != cluster.triangle_count {
            let (field, found) = ("reference_count", u64::from(cluster.reference_count));
            let expected = u64::from(cluster.triangle_count);
            return Err(row(
                SectionKind::Clusters,
                at,
                RowFault::Count { field, found, expected },
            ));
        }
        if cluster.node_count != 0 {
            check_tree(view, cluster, &mut places)?;
        }
    }
    Ok(())
}

/// What its parent says of a node.
#[derive(Clone, Copy)]
struct Place {
    /// Nodes above it.
    depth: u8,
    /// Whether its parent's boxes follow the pose, and so are on the lattice of the rest positions.
    follows: bool,
    min: [u16; 3],
    max: [u16; 3],
}

impl Place {
    /// A root has the whole lattice.
    const ROOT: Self = Self {
        depth: 0,
        follows: false,
        min: [0; 3],
        max: [u16::MAX; 3],
    };
}

fn check_tree(view: &ModelView<'_>, cluster: &ClusterRow, places: &mut [Option<Place>]) -> Result<(), FormatError> {
    let first = cluster.node_first as usize;
    let nodes = first..first + cluster.node_count as usize;
    let places = &mut places[nodes.clone()];
    places[0] = Some(Place::ROOT);
    let first_reference = cluster.reference_first as usize;
    let references = &view.references[first_reference..first_reference + cluster.reference_count as usize];
    let mut left = references.iter();
    // Children stand behind their parents, so one pass meets every parent first.
    for (own, node) in view.wide_nodes[nodes].iter().enumerate() {
        check_node(node, own, places, &mut left).map_err(|fault| row(SectionKind::WideNodes, first + own, fault))?;
    }
    match left.len() {
        0 => Ok(()),
        unused => {
            let at = first_reference + references.len() - unused;
            Err(row(SectionKind::References, at, RowFault::ReferenceUnused))
        }
    }
}

/// Checks node `own` of a tree, gives its children their places and takes its leaves' triangles from `references`.
fn check_node(
    node: &WideNodeRow,
    own: usize,
    places: &mut [Option<Place>],
    references: &mut std::slice::Iter<'_, u32>,
) -> Result<(), RowFault> {
    let Some(parent) = places[own] else {
        return Err(RowFault::NoParent);
    };
    let found = parent.depth as usize + 1;
    if found > MAX_WIDE_DEPTH {
        let limit = MAX_WIDE_DEPTH;
        return Err(RowFault::TooDeep { found, limit });
    }
    let used = node.children.iter().take_while(|word| **word != WideChild::EMPTY);
    let used = used.count();
    if used == 0 {
        return Err(RowFault::NoChildren);
    }
    let follows = node.mover_count != 0;
    for place in 0..used {
        let corner = |corners: &[[u16; 8]; 3]| [corners[0][place], corners[1][place], corners[2][place]];
        let child = Place {
            depth: parent.depth + 1,
            follows,
            min: corner(&node.min),
            max: corner(&node.max),
        };
        let around = if follows == parent.follows {
            &parent
        } else {
            &Place::ROOT
        };
        check_box(place, &child, around)?;
        match WideChild::unpack(node.children[place]) {
            WideChild::Empty => {}
            WideChild::Node(index) => claim(places, own, index, child)?,
            WideChild::Leaf(found) => match references.next() {
                Some(expected) if *expected == found => {}
                Some(&expected) => {
                    return Err(RowFault::LeafNotReferenced { place, found, expected });
                }
                None => return Err(RowFault::LeafWithoutReference { place }),
            },
        }
    }
    check_empty_places(node, used)
}

/// A child's box has a point, and none outside of its parent's.
fn check_box(place: usize, child: &Place, parent: &Place) -> Result<(), RowFault> {
    for axis in 0..3 {
        let (min, max) = (child.min[axis], child.max[axis]);
        if min > max {
            let (field, min, max) = ("box", f32::from(min), f32::from(max));
            return Err(RowFault::EmptyBox { field, axis, min, max });
        }
        let (least, greatest) = (parent.min[axis], parent.max[axis]);
        if min < least || max > greatest {
            return Err(RowFault::OutsideParentsBox {
                place,
                axis,
                min,
                max,
                least,
                greatest,
            });
        }
    }
    Ok(())
}

/// Makes node `index` the child of node `own`.
fn claim(places: &mut [Option<Place>], own: usize, index: u32, child: Place) -> Result<(), RowFault> {
    if index as usize <= own {
        let (found, own) = (index, own as u32);
        return Err(RowFault::ChildNotBehind { found, own });
    }
    let limit = places.len() as u64;
    let Some(claimed) = places.get_mut(index as usize) else {
        let (field, found) = ("child", u64::from(index));
        return Err(RowFault::IndexOutOfRange { field, found, limit });
    };
    match claimed.replace(child) {
        Some(_) => Err(RowFault::TwoParents { child: index }),
        None => Ok(()),
    }
}

/// Nothing stands behind the places in use.
fn check_empty_places(node: &WideNodeRow, used: usize) -> Result<(), RowFault> {
    for place in used..node.children.len() {
        if node.children[place] != WideChild::EMPTY {
            return Err(RowFault::PlaceBehindEmpty { place });
        }
        let corners = node.min.iter().chain(&node.max);
        if corners.into_iter().any(|corner| corner[place] != u16::MAX) {
            return Err(RowFault::BoxOfEmptyPlace { place });
        }
    }
    Ok(())
}
