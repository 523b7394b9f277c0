use super::bvh::{Bvh, BvhContent, MAX_BVH_DEPTH};
use restpose_formats::geom::Aabb;
use thiserror::Error;

/// Why a tree does not keep what [`Bvh`] promises.
///
/// Nodes, references and boxes are named by their indices. The remedy is always to build the tree again; if it was just
/// built over these boxes, the builder has a fault.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BvhFault {
    /// There is no root.
    #[error("BVH has no nodes; expected at least a root; build it first")]
    NoNodes,
    /// A child stands before its parent or past the last node.
    #[error("BVH node {node}: left child {left}; expected {node} < left < {node_count} - 1")]
    ChildOutOfRange {
        /// The parent.
        node: usize,
        /// Its left child.
        left: u32,
        /// Nodes in the tree.
        node_count: usize,
    },
    /// A node has two parents, or none and is not the root.
    #[error("BVH node {node} is reached {times} times from the root; expected once")]
    NotATree {
        /// The node.
        node: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// Traversal stacks would overflow.
    #[error("BVH node {node}: an inner node under {MAX_BVH_DEPTH} others; expected a leaf there")]
    TooDeep {
        /// The node.
        node: usize,
    },
    /// A leaf's references are not all there.
    #[error("BVH node {node}: references {first} and {count} on; expected them within {available}")]
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
    /// The leaves' ranges overlap or leave gaps.
    #[error("BVH reference {reference} is in the ranges of {times} leaves; expected one")]
    ReferencesNotPartitioned {
        /// The reference.
        reference: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// A box is listed twice, or not at all.
    #[error("BVH lists box {id} {times} times; expected once")]
    BoxNotListedOnce {
        /// The box.
        id: usize,
        /// 0, or 2 for twice or more.
        times: u32,
    },
    /// A leaf lists a box that does not exist.
    #[error("BVH node {node}: lists box {id}; expected one below {box_count}")]
    UnknownBox {
        /// The leaf.
        node: usize,
        /// The box.
        id: u32,
        /// Boxes there are.
        box_count: usize,
    },
    /// A node's box is not the smallest around its contents.
    #[error("BVH node {node}: box {found:?}; expected {expected:?}, the box around its contents")]
    WrongBounds {
        /// The node.
        node: usize,
        /// Its box.
        found: Aabb,
        /// What it should be.
        expected: Aabb,
    },
}

impl Bvh {
    /// Checks everything that [`Bvh`] promises for `boxes`, exactly.
    ///
    /// Complexity: O(nodes + references).
    ///
    /// # Errors
    /// The first [`BvhFault`] found.
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), BvhFault> {
        if self.nodes.is_empty() {
            return Err(BvhFault::NoNodes);
        }
        self.check_topology()?;
        self.check_references(boxes)?;
        for (node, row) in self.nodes.iter().enumerate() {
            let expected = match row.content() {
                BvhContent::Inner { left } => {
                    let [a, b] = [left, left + 1].map(|child| self.nodes[child as usize].bounds());
                    a.union(b)
                }
                BvhContent::Leaf { first, count } => self.references[first as usize..][..count as usize]
                    .iter()
                    .fold(Aabb::EMPTY, |bounds, id| bounds.union(boxes[*id as usize])),
            };
            if row.bounds() != expected {
                return Err(BvhFault::WrongBounds {
                    node,
                    found: row.bounds(),
                    expected,
                });
            }
        }
        Ok(())
    }

    fn check_topology(&self) -> Result<(), BvhFault> {
        let node_count = self.nodes.len();
        let mut reached = vec![false; node_count];
        let mut open = vec![(0, 0)];
        while let Some((node, depth)) = open.pop() {
            if std::mem::replace(&mut reached[node], true) {
                return Err(BvhFault::NotATree { node, times: 2 });
            }
            let BvhContent::Inner { left } = self.nodes[node].content() else {
                continue;
            };
            let first = left as usize;
            if first <= node || first + 1 >= node_count {
                return Err(BvhFault::ChildOutOfRange { node, left, node_count });
            }
            if depth == MAX_BVH_DEPTH {
                return Err(BvhFault::TooDeep { node });
            }
            open.extend([(first, depth + 1), (first + 1, depth + 1)]);
        }
        match reached.iter().position(|reached| !reached) {
            Some(node) => Err(BvhFault::NotATree { node, times: 0 }),
            None => Ok(()),
        }
    }

    fn check_references(&self, boxes: &[Aabb]) -> Result<(), BvhFault> {
        let available = self.references.len();
        let mut owned = vec![false; available];
        let mut listed = vec![false; boxes.len()];
        for (node, row) in self.nodes.iter().enumerate() {
            let BvhContent::Leaf { first, count } = row.content() else {
                continue;
            };
            let range = first as usize..first as usize + count as usize;
            let Some(references) = self.references.get(range.clone()) else {
                return Err(BvhFault::ReferencesOutOfRange {
                    node,
                    first,
                    count,
                    available,
                });
            };
            for (reference, id) in range.zip(references) {
                if std::mem::replace(&mut owned[reference], true) {
                    return Err(BvhFault::ReferencesNotPartitioned { reference, times: 2 });
                }
                let Some(listed) = listed.get_mut(*id as usize) else {
                    return Err(BvhFault::UnknownBox {
                        node,
                        id: *id,
                        box_count: boxes.len(),
                    });
                };
                if std::mem::replace(listed, true) {
                    return Err(BvhFault::BoxNotListedOnce {
                        id: *id as usize,
                        times: 2,
                    });
                }
            }
        }
        if let Some(reference) = owned.iter().position(|owned| !owned) {
            return Err(BvhFault::ReferencesNotPartitioned { reference, times: 0 });
        }
        match listed.iter().position(|listed| !listed) {
            Some(id) => Err(BvhFault::BoxNotListedOnce { id, times: 0 }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::BvhNode;

    fn boxes() -> Vec<Aabb> {
        (0..4)
            .map(|i| Aabb {
                min: [i as f32; 3],
                max: [i as f32 + 0.5; 3],
            })
            .collect()
    }

    fn around(boxes: &[Aabb]) -> Aabb {
        boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds))
    }

    fn tree() -> Bvh {
        let boxes = boxes();
        Bvh {
            nodes: vec![
                BvhNode::inner(around(&boxes), 1),
                BvhNode::leaf(around(&boxes[..2]), 0, 2),
                BvhNode::leaf(around(&boxes[2..]), 2, 2),
            ],
            references: vec![1, 0, 2, 3],
        }
    }

    #[test]
    fn a_valid_tree_passes() {
        assert_eq!(tree().validate(&boxes()), Ok(()));
    }

    #[test]
    fn each_fault_is_found() {
        let boxes = boxes();
        let fault = |change: &dyn Fn(&mut Bvh)| {
            let mut tree = tree();
            change(&mut tree);
            tree.validate(&boxes).unwrap_err()
        };
        let bounds = around(&boxes);
        assert_eq!(Bvh::default().validate(&boxes), Err(BvhFault::NoNodes));
        for left in [0, 2] {
            assert!(matches!(
                fault(&|tree| tree.nodes[0] = BvhNode::inner(bounds, left)),
                BvhFault::ChildOutOfRange { node: 0, .. }
            ));
        }
        assert_eq!(
            fault(&|tree| tree.nodes.push(tree.nodes[2])),
            BvhFault::NotATree { node: 3, times: 0 }
        );
        assert!(matches!(
            fault(&|tree| tree.nodes[2] = BvhNode::leaf(around(&boxes[2..]), 3, 2)),
            BvhFault::ReferencesOutOfRange { node: 2, .. }
        ));
        assert_eq!(
            fault(&|tree| tree.nodes[2] = BvhNode::leaf(around(&boxes[1..3]), 1, 2)),
            BvhFault::ReferencesNotPartitioned { reference: 1, times: 2 }
        );
        assert_eq!(
            fault(&|tree| tree.references.push(0)),
            BvhFault::ReferencesNotPartitioned { reference: 4, times: 0 }
        );
        assert_eq!(
            fault(&|tree| tree.references[0] = 2),
            BvhFault::BoxNotListedOnce { id: 2, times: 2 }
        );
        assert!(matches!(
            fault(&|tree| tree.references[0] = 4),
            BvhFault::UnknownBox { node: 1, id: 4, .. }
        ));
        assert_eq!(
            tree().validate(&[boxes.clone(), vec![bounds]].concat()),
            Err(BvhFault::BoxNotListedOnce { id: 4, times: 0 })
        );
        let mut larger = bounds;
        larger.max[2] = larger.max[2].next_up();
        assert!(matches!(
            fault(&|tree| tree.nodes[0] = BvhNode::inner(larger, 1)),
            BvhFault::WrongBounds { node: 0, .. }
        ));
        let mut smaller = around(&boxes[..2]);
        smaller.min[1] = smaller.min[1].next_up();
        assert!(matches!(
            fault(&|tree| tree.nodes[1] = BvhNode::leaf(smaller, 0, 2)),
            BvhFault::WrongBounds { .. }
        ));
    }

    #[test]
    fn a_chain_that_is_too_deep_is_found() {
        let chain = |inner: usize| {
            let boxes = vec![Aabb::around([[0.0; 3]]); inner + 1];
            let mut nodes = vec![BvhNode::inner(boxes[0], 1)];
            for i in 1..inner {
                nodes.push(BvhNode::leaf(boxes[0], i as u32 - 1, 1));
                nodes.push(BvhNode::inner(boxes[0], nodes.len() as u32 + 1));
            }
            nodes.extend([inner as u32 - 1, inner as u32].map(|first| BvhNode::leaf(boxes[0], first, 1)));
            let references = (0..=inner as u32).collect();
            Bvh { nodes, references }.validate(&boxes)
        };
        assert_eq!(chain(MAX_BVH_DEPTH), Ok(()));
        assert!(matches!(chain(MAX_BVH_DEPTH + 1), Err(BvhFault::TooDeep { .. })));
    }
}
