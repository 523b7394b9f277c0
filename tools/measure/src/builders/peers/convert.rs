use super::failed;
use crate::MeasureError;
use restpose_runtime::{
    Aabb,
    build::{Bvh, BvhContent, BvhNode, MAX_BVH_DEPTH},
};

/// A node of a peer's tree.
pub(super) enum PeerNode<'a> {
    /// Its children.
    Inner([usize; 2]),
    /// Indices of boxes.
    Leaf(&'a [u32]),
}

/// A peer's tree in the runtime's form: the same topology, with boxes made anew. What lies deeper than the runtime's
/// traversal goes is a leaf.
pub(super) fn convert<'a>(
    peer: &'static str,
    boxes: &[Aabb],
    root: usize,
    node: impl Fn(usize) -> Option<PeerNode<'a>>,
) -> Result<Bvh, MeasureError> {
    let mut tree = Bvh {
        nodes: vec![BvhNode::leaf(Aabb::EMPTY, 0, 0)],
        references: Vec::with_capacity(boxes.len()),
    };
    // A tree of n leaves has 2n − 1 nodes: more are no tree, and would be walked for ever.
    let mut visits_left = 2 * boxes.len();
    let mut visit = |place: usize| {
        visits_left = visits_left
            .checked_sub(1)
            .ok_or_else(|| failed(peer, "its nodes are no tree"))?;
        node(place).ok_or_else(|| failed(peer, format!("its node {place} does not exist")))
    };
    let mut open = vec![(root, 0, 0)];
    let mut below = Vec::new();
    while let Some((from, to, depth)) = open.pop() {
        let first = tree.references.len() as u32;
        match visit(from)? {
            PeerNode::Inner(children) if depth < MAX_BVH_DEPTH => {
                let left = tree.nodes.len();
                tree.nodes.extend([BvhNode::leaf(Aabb::EMPTY, 0, 0); 2]);
                tree.nodes[to] = BvhNode::inner(Aabb::EMPTY, left as u32);
                // The left one is taken first.
                open.push((children[1], left + 1, depth + 1));
                open.push((children[0], left, depth + 1));
                continue;
            }
            PeerNode::Inner(children) => {
                below.extend(children);
                while let Some(from) = below.pop() {
                    match visit(from)? {
                        PeerNode::Inner(children) => below.extend(children),
                        PeerNode::Leaf(ids) => tree.references.extend_from_slice(ids),
                    }
                }
            }
            PeerNode::Leaf(ids) => tree.references.extend_from_slice(ids),
        }
        tree.nodes[to] = BvhNode::leaf(Aabb::EMPTY, first, tree.references.len() as u32 - first);
    }
    for place in (0..tree.nodes.len()).rev() {
        tree.nodes[place] = match tree.nodes[place].content() {
            // A leaf of nothing looks like an inner node.
            BvhContent::Inner { left } if left as usize <= place => return Err(failed(peer, "it has an empty leaf")),
            BvhContent::Inner { left } => {
                let [a, b] = [left, left + 1].map(|child| tree.nodes[child as usize].bounds());
                BvhNode::inner(a.union(b), left)
            }
            BvhContent::Leaf { first, count } => {
                let mut bounds = Aabb::EMPTY;
                for id in &tree.references[first as usize..][..count as usize] {
                    let own = boxes.get(*id as usize);
                    bounds = bounds.union(*own.ok_or_else(|| failed(peer, format!("it lists box {id}")))?);
                }
                BvhNode::leaf(bounds, first, count)
            }
        };
    }
    Ok(tree)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(count: usize) -> Vec<Aabb> {
        let unit = |i: usize| Aabb {
            min: [i as f32; 3],
            max: [i as f32 + 1.0; 3],
        };
        (0..count).map(unit).collect()
    }

    #[test]
    fn topology_is_kept_and_boxes_are_made_anew() {
        let nodes = |place: usize| match place {
            7 => Some(PeerNode::Inner([3, 9])),
            3 => Some(PeerNode::Leaf(&[2])),
            9 => Some(PeerNode::Leaf(&[0, 1])),
            _ => None,
        };
        let tree = convert("peer", &boxes(3), 7, nodes).unwrap();
        tree.validate(&boxes(3)).unwrap();
        assert_eq!(tree.references, [2, 0, 1]);
        assert_eq!(tree.nodes[2].content(), BvhContent::Leaf { first: 1, count: 2 });
    }

    #[test]
    fn what_is_too_deep_becomes_a_leaf() {
        // A chain: node 2i has the leaf 2i + 1 and the node 2i + 2.
        let ids: Vec<u32> = (0..200).collect();
        let nodes = |place: usize| match place {
            398 => Some(PeerNode::Leaf(&ids[199..])),
            _ if place % 2 == 1 => Some(PeerNode::Leaf(&ids[place / 2..][..1])),
            _ => Some(PeerNode::Inner([place + 1, place + 2])),
        };
        let tree = convert("peer", &boxes(200), 0, nodes).unwrap();
        tree.validate(&boxes(200)).unwrap();
        assert_eq!(tree.nodes.len(), 2 * MAX_BVH_DEPTH + 1);
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let round = |_| Some(PeerNode::Inner([0, 0]));
        assert!(convert("peer", &boxes(3), 0, round).is_err());
        let missing = |place: usize| (place == 0).then_some(PeerNode::Inner([1, 2]));
        assert!(convert("peer", &boxes(3), 0, missing).is_err());
        let unknown = |_| Some(PeerNode::Leaf(&[3]));
        assert!(convert("peer", &boxes(3), 0, unknown).is_err());
        let empty = |_| Some(PeerNode::Leaf(&[]));
        assert!(convert("peer", &boxes(3), 0, empty).is_err());
    }
}
