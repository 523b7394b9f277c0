use super::finite_box::finite_box;
use super::kd_tree::KdTree;
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, MAX_KD_DEPTH};
use thiserror::Error;

/// Why a kd-tree does not keep what [`KdTree`] promises.
///
/// Nodes, references and boxes are named by their indices. The remedy is always to build the tree again; if it was just
/// built over these boxes, the builder has a fault.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum KdFault {
    /// There is no root.
    #[error("kd-tree has no nodes; expected at least a root; build it first")]
    NoNodes,
    /// A child stands before its parent or past the last node.
    #[error("kd-tree node {node}: left child {left}; expected {node} < left < {node_count} - 1")]
    ChildOutOfRange {
        /// The parent.
        node: usize,
        /// Its left child.
        left: u32,
        /// Nodes in the tree.
        node_count: usize,
    },
    /// A node has two parents, or none and is not the root.
    #[error("kd-tree node {node} is reached {times} times from the root; expected once")]
    NotATree {
        /// The node.
        node: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// Traversal stacks would overflow.
    #[error("kd-tree node {node}: an inner node under {MAX_KD_DEPTH} others; expected a leaf there")]
    TooDeep {
        /// The node.
        node: usize,
    },
    /// A plane misses the cell it splits.
    #[error("kd-tree node {node}: split {split} on axis {axis}; expected it within {min} to {max}")]
    SplitOutsideCell {
        /// The node.
        node: usize,
        /// Its axis.
        axis: usize,
        /// Its plane.
        split: f32,
        /// Lower side of its cell.
        min: f32,
        /// Upper side of its cell.
        max: f32,
    },
    /// A leaf's references are not all there.
    #[error("kd-tree node {node}: references {first} and {count} on; expected them within {available}")]
    ReferencesOutOfRange {
        /// The leaf.
        node: usize,
        /// Its first reference.
        first: u32,
        /// Its references.
        count: u32,
        /// References in the tree.
        available: usize,
    },
    /// A leaf's references do not ascend.
    #[error("kd-tree node {node}: box {next} is listed after box {previous}; expected ascending boxes")]
    ReferencesOutOfOrder {
        /// The leaf.
        node: usize,
        /// A reference.
        previous: u32,
        /// The one behind it.
        next: u32,
    },
    /// The leaves' ranges overlap or leave gaps.
    #[error("kd-tree reference {reference} is in the ranges of {times} leaves; expected one")]
    ReferencesNotPartitioned {
        /// The reference.
        reference: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// A leaf lists a box that does not exist.
    #[error("kd-tree node {node}: lists box {id}; expected one below {box_count}")]
    UnknownBox {
        /// The leaf.
        node: usize,
        /// The box.
        id: u32,
        /// Boxes there are.
        box_count: usize,
    },
    /// A leaf lists a box that has no point in its cell.
    #[error("kd-tree node {node}: lists box {id}, which is empty or misses the cell; expected overlapping boxes only")]
    BoxMissesCell {
        /// The leaf.
        node: usize,
        /// The box.
        id: u32,
    },
    /// A box is not within the bounds.
    #[error("kd-tree bounds do not contain box {id}; expected the box around all boxes")]
    BoundsTooSmall {
        /// The box.
        id: usize,
    },
    /// Points of a box lie in no leaf that lists it.
    #[error("kd-tree node {node}: does not list box {id}, points of which only this leaf could find")]
    BoxNotListed {
        /// A leaf where the box should be.
        node: usize,
        /// The box.
        id: usize,
    },
}

/// The part of a box in a cell, per axis.
type Region = [[f32; 2]; 3];

impl KdTree {
    /// Checks everything that [`KdTree`] promises for `boxes`, exactly.
    ///
    /// Complexity: O(nodes + references × log of the largest leaf) for a valid tree.
    ///
    /// # Errors
    /// The first [`KdFault`] found.
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), KdFault> {
        self.check_nodes(boxes)?;
        for (id, bounds) in boxes.iter().enumerate() {
            let Some(bounds) = finite_box(bounds) else {
                continue;
            };
            if !self.bounds.contains_box(&bounds) {
                return Err(KdFault::BoundsTooSmall { id });
            }
            let region = std::array::from_fn(|k| [bounds.min[k], bounds.max[k]]);
            if let Some(node) = self.unlisted(0, region, id) {
                return Err(KdFault::BoxNotListed { node, id });
            }
        }
        Ok(())
    }

    /// Checks the topology, and each leaf against its cell.
    fn check_nodes(&self, boxes: &[Aabb]) -> Result<(), KdFault> {
        if self.nodes.is_empty() {
            return Err(KdFault::NoNodes);
        }
        let node_count = self.nodes.len();
        let mut reached = vec![false; node_count];
        let mut listed = vec![false; self.references.len()];
        let mut open = vec![(0, 0, self.bounds)];
        while let Some((node, depth, cell)) = open.pop() {
            if std::mem::replace(&mut reached[node], true) {
                return Err(KdFault::NotATree { node, times: 2 });
            }
            match self.nodes[node].unpack() {
                KdNode::Inner { axis, split, left } => {
                    let first = left as usize;
                    if first <= node || first + 1 >= node_count {
                        return Err(KdFault::ChildOutOfRange { node, left, node_count });
                    }
                    if depth == MAX_KD_DEPTH {
                        return Err(KdFault::TooDeep { node });
                    }
                    let (min, max) = (cell.min[axis], cell.max[axis]);
                    if !(min <= split && split <= max) {
                        return Err(KdFault::SplitOutsideCell {
                            node,
                            axis,
                            split,
                            min,
                            max,
                        });
                    }
                    let (mut lower, mut upper) = (cell, cell);
                    lower.max[axis] = split;
                    upper.min[axis] = split;
                    open.push((first, depth + 1, lower));
                    open.push((first + 1, depth + 1, upper));
                }
                KdNode::Leaf { first, count } => {
                    self.check_leaf(node, first, count, &cell, boxes)?;
                    let range = listed.iter_mut().enumerate().skip(first as usize).take(count as usize);
                    for (reference, listed) in range {
                        if std::mem::replace(listed, true) {
                            return Err(KdFault::ReferencesNotPartitioned { reference, times: 2 });
                        }
                    }
                }
            }
        }
        if let Some(node) = reached.iter().position(|reached| !reached) {
            return Err(KdFault::NotATree { node, times: 0 });
        }
        match listed.iter().position(|listed| !listed) {
            Some(reference) => Err(KdFault::ReferencesNotPartitioned { reference, times: 0 }),
            None => Ok(()),
        }
    }

    fn check_leaf(&self, node: usize, first: u32, count: u32, cell: &Aabb, boxes: &[Aabb]) -> Result<(), KdFault> {
        let available = self.references.len();
        let Some(references) = self.leaf(first, count) else {
            return Err(KdFault::ReferencesOutOfRange {
                node,
                first,
                count,
                available,
            });
        };
        if let Some(pair) = references.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(KdFault::ReferencesOutOfOrder {
                node,
                previous: pair[0],
                next: pair[1],
            });
        }
        for &id in references {
            let Some(bounds) = boxes.get(id as usize) else {
                return Err(KdFault::UnknownBox {
                    node,
                    id,
                    box_count: boxes.len(),
                });
            };
            if !finite_box(bounds).is_some_and(|bounds| bounds.overlaps(cell)) {
                return Err(KdFault::BoxMissesCell { node, id });
            }
        }
        Ok(())
    }

    fn leaf(&self, first: u32, count: u32) -> Option<&[u32]> {
        self.references
            .get(first as usize..(first as usize).checked_add(count as usize)?)
    }

    /// A leaf below `node` that should list the box but does not; `region` is the part of the box in the node's cell.
    ///
    /// Recursion is bounded: the depth of the tree was checked before.
    fn unlisted(&self, node: usize, region: Region, id: usize) -> Option<usize> {
        match self.nodes[node].unpack() {
            KdNode::Leaf { first, count } => {
                let listed = |id: u32| {
                    self.leaf(first, count)
                        .is_some_and(|list| list.binary_search(&id).is_ok())
                };
                let listed = u32::try_from(id).is_ok_and(listed);
                (!listed).then_some(node)
            }
            KdNode::Inner { axis, split, left } => {
                let left = left as usize;
                let [min, max] = region[axis];
                if min == split && max == split {
                    // Points in the plane are found on either side.
                    return self
                        .unlisted(left, region, id)
                        .and_then(|_| self.unlisted(left + 1, region, id));
                }
                // Points strictly below the plane can only be found on the left; cells are closed, so with them come
                // those in the plane. The same holds above it.
                let (mut lower, mut upper) = (region, region);
                lower[axis][1] = max.min(split);
                upper[axis][0] = min.max(split);
                let below = (min < split).then(|| self.unlisted(left, lower, id)).flatten();
                below.or_else(|| (max > split).then(|| self.unlisted(left + 1, upper, id)).flatten())
            }
        }
    }
}
