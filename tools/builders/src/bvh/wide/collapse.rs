use super::{
    WideBvh, box_of,
    plan::{Plan, WIDTH},
};
use restpose_formats::{
    geom::Aabb,
    rows::{ReferenceBoxRow, WideChild, WideNodeRow},
};
use restpose_runtime::build::{Bvh, BvhContent};

/// Replaces `wide` by the best wide hierarchy that comes of dissolving nodes of `tree`, which has one box to a leaf.
///
/// `most_depth` is the greatest number of nodes on a path to a leaf. Where the best hierarchy might not end in time, boxes
/// are parted into eight equal lists in their order in `tree`.
pub(super) fn collapse(tree: &Bvh, boxes: &[Aabb], most_depth: usize, wide: &mut WideBvh) {
    wide.bounds = tree.bounds();
    wide.nodes.clear();
    let mut collapse = Collapse {
        tree,
        plan: &Plan::new(tree),
        boxes,
        most_depth,
        bounds: wide.bounds,
        nodes: &mut wide.nodes,
    };
    collapse.add_node(Below::Node(0), 0);
    let leaves = wide.nodes.iter().flat_map(WideNodeRow::children);
    wide.references.clear();
    wide.references.extend(leaves.filter_map(|child| match child {
        WideChild::Leaf(id) => Some(id),
        _ => None,
    }));
}

/// What stands in one place.
enum Below {
    /// A node of the binary hierarchy.
    Node(u32),
    /// Boxes, at least one, that are parted equally.
    Boxes(Vec<u32>),
}

struct Collapse<'a> {
    tree: &'a Bvh,
    plan: &'a Plan,
    boxes: &'a [Aabb],
    most_depth: usize,
    bounds: Aabb,
    nodes: &'a mut Vec<WideNodeRow>,
}

impl Collapse<'_> {
    /// Adds the wide node over `below`, under `depth` others, and all that is below it. Returns its box.
    fn add_node(&mut self, below: Below, depth: usize) -> ReferenceBoxRow {
        let at = self.nodes.len();
        self.nodes.push(WideNodeRow::EMPTY);
        let (leaves, inner): (Vec<Below>, Vec<Below>) = self
            .children(below, depth)
            .into_iter()
            .partition(|child| self.leaf(child).is_some());
        let mut around = ReferenceBoxRow {
            min: [u16::MAX; 3],
            max: [0; 3],
        };
        for (place, child) in leaves.into_iter().chain(inner).enumerate() {
            let (word, bounds) = match self.leaf(&child) {
                Some(id) => {
                    let bounds = ReferenceBoxRow::around(&self.boxes[id as usize], &self.bounds);
                    (WideChild::Leaf(id), bounds)
                }
                None => {
                    let child_at = self.nodes.len() as u32;
                    (WideChild::Node(child_at), self.add_node(child, depth + 1))
                }
            };
            let node = &mut self.nodes[at];
            node.children[place] = word.pack();
            for k in 0..3 {
                (node.min[k][place], node.max[k][place]) = (bounds.min[k], bounds.max[k]);
            }
            around = union(around, box_of(node, place));
        }
        around
    }

    /// The box that is all of it.
    fn leaf(&self, below: &Below) -> Option<u32> {
        match below {
            Below::Boxes(ids) => match ids[..] {
                [id] => Some(id),
                _ => None,
            },
            Below::Node(node) => match self.tree.nodes[*node as usize].content() {
                BvhContent::Leaf { first, .. } => Some(self.tree.references[first as usize]),
                BvhContent::Inner { .. } => None,
            },
        }
    }

    fn children(&self, below: Below, depth: usize) -> Vec<Below> {
        match below {
            Below::Node(node) if must_part_equally(depth, self.plan.count(node), self.most_depth) => {
                equal_parts(&self.boxes_below(node))
            }
            Below::Node(node) => {
                let mut nodes = Vec::with_capacity(WIDTH);
                self.plan.children(self.tree, node, &mut nodes);
                nodes.into_iter().map(Below::Node).collect()
            }
            Below::Boxes(ids) => equal_parts(&ids),
        }
    }

    /// Boxes below a binary node, from left to right.
    fn boxes_below(&self, node: u32) -> Vec<u32> {
        let (mut ids, mut open) = (Vec::with_capacity(self.plan.count(node)), vec![node]);
        while let Some(node) = open.pop() {
            match self.tree.nodes[node as usize].content() {
                BvhContent::Leaf { first, .. } => ids.push(self.tree.references[first as usize]),
                BvhContent::Inner { left } => open.extend([left + 1, left]),
            }
        }
        ids
    }
}

fn union(a: ReferenceBoxRow, b: ReferenceBoxRow) -> ReferenceBoxRow {
    ReferenceBoxRow {
        min: [0, 1, 2].map(|k| a.min[k].min(b.min[k])),
        max: [0, 1, 2].map(|k| a.max[k].max(b.max[k])),
    }
}

/// At most eight parts whose lengths differ by one at most.
fn equal_parts(ids: &[u32]) -> Vec<Below> {
    let parts = ids.len().min(WIDTH);
    (0..parts)
        .map(|part| Below::Boxes(ids[part * ids.len() / parts..(part + 1) * ids.len() / parts].to_vec()))
        .collect()
}

/// Whether a node over `count` boxes, under `depth` others, must be parted equally for all below to stay within
/// `most_depth`.
///
/// Equal parts end after ⌈log₈ count⌉ nodes. While those still fit below a child with as many boxes, any children are
/// allowed; from the first node on where they might not, all are parted equally, and a leaf never stands deeper.
fn must_part_equally(depth: usize, count: usize, most_depth: usize) -> bool {
    depth + 1 + levels(count) > most_depth
}

/// Nodes on the longest path through equal parts.
fn levels(count: usize) -> usize {
    let mut levels = 1;
    let mut count = count;
    while count > WIDTH {
        count = count.div_ceil(WIDTH);
        levels += 1;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::rows::MAX_WIDE_DEPTH;

    /// Nodes on the longest path when each node cuts off a single box as long as that is allowed.
    fn deepest(depth: usize, count: usize) -> usize {
        match count {
            1 => depth,
            _ if must_part_equally(depth, count, MAX_WIDE_DEPTH) => depth + levels(count),
            _ => deepest(depth + 1, count - 1),
        }
    }

    #[test]
    fn the_worst_nodes_stay_within_the_depth() {
        for count in (2..3000).chain([1 << 20, (1 << 20) + 1, WideBvh::MAX_COUNT]) {
            assert!(deepest(0, count) <= MAX_WIDE_DEPTH, "{count}");
        }
        assert_eq!(deepest(0, WideBvh::MAX_COUNT), MAX_WIDE_DEPTH);
        assert!(!must_part_equally(0, WideBvh::MAX_COUNT, MAX_WIDE_DEPTH));
    }

    #[test]
    fn equal_parts_hold_all_in_order_and_end_after_so_many_levels() {
        fn longest_path(ids: &[u32], out: &mut Vec<u32>) -> usize {
            let below = equal_parts(ids).into_iter().map(|part| match part {
                Below::Boxes(ids) if ids.len() == 1 => {
                    out.extend(ids);
                    0
                }
                Below::Boxes(ids) => longest_path(&ids, out),
                Below::Node(_) => usize::MAX,
            });
            1 + below.max().unwrap_or(0)
        }
        for count in (1..600).chain([4095, 4096, 4097]) {
            let ids: Vec<u32> = (0..count).collect();
            let mut met = Vec::new();
            assert!(longest_path(&ids, &mut met) <= levels(count as usize), "{count}");
            assert_eq!(met, ids);
        }
    }
}
