use super::{WideBvh, box_of};
use restpose_formats::{
    geom::Aabb,
    rows::{MAX_WIDE_DEPTH, ReferenceBoxRow, WideChild, WideNodeRow},
};
use thiserror::Error;

/// Why a tree does not keep what [`WideBvh`] promises.
///
/// Nodes, places and boxes are named by their indices. The remedy is always to build the tree again; if it was just built
/// over these boxes, the builder has a fault.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum WideFault {
    /// There is no root.
    #[error("wide BVH has no nodes; expected at least a root; build it first")]
    NoNodes,
    /// The bounds are not the smallest around all boxes.
    #[error("wide BVH has bounds {found:?}; expected {expected:?}, the box around all boxes")]
    WrongBounds {
        /// Its bounds.
        found: Aabb,
        /// What they should be.
        expected: Aabb,
    },
    /// A node has no children.
    #[error("wide BVH node {node}: all places are empty; expected a child")]
    NoChildren {
        /// The node.
        node: usize,
    },
    /// Something stands behind an empty place, or has a box there.
    #[error(
        "wide BVH node {node}: place {place} is in use behind an empty one; expected it empty, with 65535 in its box"
    )]
    NotEmpty {
        /// The node.
        node: usize,
        /// The place.
        place: usize,
    },
    /// Nodes do not stand depth first.
    #[error("wide BVH node {node}: place {place} is node {found}; expected {expected}, the first behind what was met")]
    NotDepthFirst {
        /// The node.
        node: usize,
        /// The place.
        place: usize,
        /// The child.
        found: u32,
        /// What it should be.
        expected: usize,
    },
    /// Nodes that no path reaches.
    #[error("wide BVH has {found} nodes; expected {expected}, those that are reached from the root")]
    Unreached {
        /// Nodes.
        found: usize,
        /// Nodes that are reached.
        expected: usize,
    },
    /// A leaf stands behind a node.
    #[error("wide BVH node {node}: place {place} is a leaf behind a node; expected leaves first")]
    LeafBehindNode {
        /// The node.
        node: usize,
        /// The place.
        place: usize,
    },
    /// Traversal stacks would overflow.
    #[error("wide BVH node {node}: under {MAX_WIDE_DEPTH} others; expected a leaf there")]
    TooDeep {
        /// The node.
        node: usize,
    },
    /// A leaf names a box that does not exist.
    #[error("wide BVH node {node}: place {place} is box {id}; expected one below {box_count}")]
    UnknownBox {
        /// The node.
        node: usize,
        /// The place.
        place: usize,
        /// The box.
        id: u32,
        /// Boxes there are.
        box_count: usize,
    },
    /// A box has two leaves, or none.
    #[error("wide BVH has {times} leaves for box {id}; expected one")]
    BoxNotListedOnce {
        /// The box.
        id: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// The references are not those of the leaves.
    #[error("wide BVH has other references than its leaves in order: {found} of them; expected {expected}")]
    WrongReferences {
        /// References.
        found: usize,
        /// Leaves.
        expected: usize,
    },
    /// A place's box is not the smallest around what stands in it.
    #[error(
        "wide BVH node {node}: place {place} has box {found:?}; expected {expected:?}, the one around its contents"
    )]
    WrongBox {
        /// The node.
        node: usize,
        /// The place.
        place: usize,
        /// Its box.
        found: ReferenceBoxRow,
        /// What it should be.
        expected: ReferenceBoxRow,
    },
}

impl WideBvh {
    /// Checks everything that [`WideBvh`] promises for `boxes`, exactly.
    ///
    /// Complexity: O(nodes + boxes).
    ///
    /// # Errors
    /// The first [`WideFault`] found.
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), WideFault> {
        if self.nodes.is_empty() {
            return Err(WideFault::NoNodes);
        }
        let expected = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
        if self.bounds != expected {
            let found = self.bounds;
            return Err(WideFault::WrongBounds { found, expected });
        }
        let mut walk = Walk {
            tree: self,
            boxes,
            reached: 1,
            listed: vec![false; boxes.len()],
        };
        walk.node(0, 0)?;
        let (found, expected) = (self.nodes.len(), walk.reached);
        if found != expected {
            return Err(WideFault::Unreached { found, expected });
        }
        if let Some(id) = walk.listed.iter().position(|listed| !listed) {
            return Err(WideFault::BoxNotListedOnce { id, times: 0 });
        }
        let leaves = self.nodes.iter().flat_map(WideNodeRow::children);
        let leaves = leaves.filter_map(|child| match child {
            WideChild::Leaf(id) => Some(id),
            _ => None,
        });
        if leaves.eq(self.references.iter().copied()) {
            return Ok(());
        }
        let (found, expected) = (self.references.len(), boxes.len());
        Err(WideFault::WrongReferences { found, expected })
    }

    /// Nodes on the longest path to a leaf of a valid tree.
    #[must_use]
    pub fn depth(&self) -> usize {
        let mut depths = vec![0; self.nodes.len()];
        for (at, node) in self.nodes.iter().enumerate() {
            let own = depths[at];
            for child in node.children() {
                if let WideChild::Node(child) = child
                    && let Some(below) = depths.get_mut(child as usize)
                {
                    *below = own + 1;
                }
            }
        }
        depths.into_iter().max().map_or(0, |depth| depth + 1)
    }
}

struct Walk<'a> {
    tree: &'a WideBvh,
    boxes: &'a [Aabb],
    /// Nodes met so far.
    reached: usize,
    /// Per box, whether a leaf names it.
    listed: Vec<bool>,
}

impl Walk<'_> {
    /// Checks a node under `depth` others, and all below; returns the box around its places.
    fn node(&mut self, node: usize, depth: usize) -> Result<ReferenceBoxRow, WideFault> {
        if depth >= MAX_WIDE_DEPTH {
            return Err(WideFault::TooDeep { node });
        }
        let row = &self.tree.nodes[node];
        let used = row.children().count();
        if used == 0 {
            return Err(WideFault::NoChildren { node });
        }
        for place in used..row.children.len() {
            let bounds = box_of(row, place);
            if row.children[place] != WideChild::EMPTY || bounds != box_of(&WideNodeRow::EMPTY, place) {
                return Err(WideFault::NotEmpty { node, place });
            }
        }
        let mut around = ReferenceBoxRow {
            min: [u16::MAX; 3],
            max: [0; 3],
        };
        let mut met_node = false;
        for (place, child) in row.children().enumerate() {
            let expected = match child {
                WideChild::Node(found) => {
                    met_node = true;
                    self.child(node, place, found, depth)?
                }
                WideChild::Leaf(_) if met_node => return Err(WideFault::LeafBehindNode { node, place }),
                WideChild::Leaf(id) => self.leaf(node, place, id)?,
                WideChild::Empty => return Err(WideFault::NotEmpty { node, place }),
            };
            let found = box_of(row, place);
            if found != expected {
                return Err(WideFault::WrongBox {
                    node,
                    place,
                    found,
                    expected,
                });
            }
            for k in 0..3 {
                around.min[k] = around.min[k].min(found.min[k]);
                around.max[k] = around.max[k].max(found.max[k]);
            }
        }
        Ok(around)
    }

    fn child(&mut self, node: usize, place: usize, found: u32, depth: usize) -> Result<ReferenceBoxRow, WideFault> {
        let expected = self.reached;
        if found as usize != expected || expected >= self.tree.nodes.len() {
            return Err(WideFault::NotDepthFirst {
                node,
                place,
                found,
                expected,
            });
        }
        self.reached += 1;
        self.node(expected, depth + 1)
    }

    fn leaf(&mut self, node: usize, place: usize, id: u32) -> Result<ReferenceBoxRow, WideFault> {
        let Some(bounds) = self.boxes.get(id as usize) else {
            return Err(WideFault::UnknownBox {
                node,
                place,
                id,
                box_count: self.boxes.len(),
            });
        };
        if std::mem::replace(&mut self.listed[id as usize], true) {
            return Err(WideFault::BoxNotListedOnce {
                id: id as usize,
                times: 2,
            });
        }
        Ok(ReferenceBoxRow::around(bounds, &self.tree.bounds))
    }
}
