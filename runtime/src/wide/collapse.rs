use super::WideNode;
use crate::{
    Aabb,
    build::{Bvh, BvhContent},
};
use restpose_formats::rows::{NONE, WideChild};

/// Part of a binary tree that is to stand in one place.
#[derive(Clone, Copy)]
struct Part {
    bounds: Aabb,
    area: f64,
    content: BvhContent,
}

impl Part {
    const NONE: Self = Self {
        bounds: Aabb::EMPTY,
        area: 0.0,
        content: BvhContent::Leaf { first: 0, count: 0 },
    };

    fn new(bounds: Aabb, content: BvhContent) -> Self {
        Self {
            bounds,
            area: bounds.surface_area(),
            content,
        }
    }

    fn can_open(&self) -> bool {
        !matches!(self.content, BvhContent::Leaf { count: 0 | 1, .. })
    }

    /// Its two halves: the children of an inner node, or the halves of a leaf's references.
    fn halves(&self, bvh: &Bvh, boxes: &[Aabb]) -> [Self; 2] {
        match self.content {
            BvhContent::Inner { left } => [left, left + 1].map(|child| {
                let node = &bvh.nodes[child as usize];
                Self::new(node.bounds(), node.content())
            }),
            BvhContent::Leaf { first, count } => {
                let half = count / 2;
                [(first, half), (first + half, count - half)].map(|(first, count)| {
                    let references = &bvh.references[first as usize..][..count as usize];
                    let bounds = references
                        .iter()
                        .fold(Aabb::EMPTY, |union, reference| union.union(boxes[*reference as usize]));
                    Self::new(bounds, BvhContent::Leaf { first, count })
                })
            }
        }
    }
}

/// Appends a wide tree to `nodes` that has a leaf for each reference of `bvh`, called what `leaf` makes of it, and returns
/// the index of its root. A tree without nodes becomes a root without children.
///
/// `boxes` are those that the tree was built over. Each node opens the part with the largest area until it has eight.
///
/// Based on: Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008, §3.1 (collapsing by surface area).
pub(crate) fn collapse(bvh: &Bvh, boxes: &[Aabb], leaf: impl Fn(u32) -> u32, nodes: &mut Vec<WideNode>) -> u32 {
    let root = nodes.len() as u32;
    let Some(top) = bvh.nodes.first() else {
        nodes.push(WideNode::EMPTY);
        return root;
    };
    nodes.push(promised(top.content(), NONE));
    let mut next = root;
    while next != NONE {
        let (content, before) = promise(&nodes[next as usize]);
        let (parts, count) = open(content, bvh, boxes);
        let mut node = WideNode::EMPTY;
        let mut latest = before;
        for (place, part) in parts[..count].iter().enumerate() {
            let child = match part.content {
                BvhContent::Leaf { first, count: 1 } => WideChild::Leaf(leaf(bvh.references[first as usize])),
                content => {
                    nodes.push(promised(content, latest));
                    latest = (nodes.len() - 1) as u32;
                    WideChild::Node(latest)
                }
            };
            node.children[place] = child.pack();
            node.set_bounds(place, &part.bounds);
        }
        nodes[next as usize] = node;
        next = latest;
    }
    root
}

/// A node whose turn has not come. What it will hold, and the node whose turn is after it, stand where its children will
/// be, so that nothing else need be allocated. Turns go depth first, which keeps near in memory what is near in space.
fn promised(content: BvhContent, before: u32) -> WideNode {
    let mut node = WideNode::EMPTY;
    let (first, count) = match content {
        BvhContent::Inner { left } => (left, 0),
        BvhContent::Leaf { first, count } => (first, count),
    };
    node.children[..3].copy_from_slice(&[first, count, before]);
    node
}

/// What a [`promised`] node will hold, and whose turn is after it.
fn promise(node: &WideNode) -> (BvhContent, u32) {
    let [first, count, before, ..] = node.children;
    let content = match count {
        0 => BvhContent::Inner { left: first },
        count => BvhContent::Leaf { first, count },
    };
    (content, before)
}

/// The parts of a node's eight places, and how many there are.
fn open(content: BvhContent, bvh: &Bvh, boxes: &[Aabb]) -> ([Part; 8], usize) {
    let mut parts = [Part::NONE; 8];
    match content {
        // The box of a single reference is its own; that of a part which is opened does not matter.
        BvhContent::Leaf { first, count: 1 } => {
            parts[0] = Part::new(boxes[bvh.references[first as usize] as usize], content);
        }
        _ => parts[0].content = content,
    }
    let mut count = 1;
    while count < 8 {
        let openable = (0..count).filter(|place| parts[*place].can_open());
        let largest = openable.reduce(|best, place| {
            if parts[place].area > parts[best].area {
                place
            } else {
                best
            }
        });
        let Some(largest) = largest else {
            break;
        };
        [parts[largest], parts[count]] = parts[largest].halves(bvh, boxes);
        count += 1;
    }
    (parts, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::BvhNode;

    fn cube(at: f32, side: f32) -> Aabb {
        Aabb {
            min: [at; 3],
            max: [at + side; 3],
        }
    }

    fn nodes_of(bvh: &Bvh, boxes: &[Aabb]) -> Vec<WideNode> {
        let mut nodes = vec![WideNode::EMPTY; 3];
        assert_eq!(collapse(bvh, boxes, |reference| reference + 100, &mut nodes), 3);
        nodes.split_off(3)
    }

    #[test]
    fn largest_parts_are_opened_first() {
        // A comb: each inner node has a leaf of one on the left, and shrinks.
        let boxes: Vec<Aabb> = (0..10).map(|at| cube(at as f32, 1.0)).collect();
        let mut bvh = Bvh {
            references: (0..10).collect(),
            ..Bvh::default()
        };
        let rest = |at: u32| Aabb {
            min: [at as f32; 3],
            max: [10.0; 3],
        };
        bvh.nodes.push(BvhNode::inner(rest(0), 1));
        for at in 0..9 {
            bvh.nodes.push(BvhNode::leaf(boxes[at as usize], at, 1));
            bvh.nodes.push(match at {
                8 => BvhNode::leaf(boxes[9], 9, 1),
                _ => BvhNode::inner(rest(at + 1), 2 * at + 3),
            });
        }
        let nodes = nodes_of(&bvh, &boxes);
        assert_eq!(nodes.len(), 2);
        let mut first: Vec<WideChild> = nodes[0].children.map(WideChild::unpack).to_vec();
        assert_eq!(first.pop(), Some(WideChild::Node(4)), "in the slice, not in the tree");
        assert_eq!(first, (100..107).map(WideChild::Leaf).collect::<Vec<_>>());
        assert_eq!(nodes[0].bounds(7), rest(7));
        assert_eq!(nodes[1].around(), rest(7));
    }

    #[test]
    fn leaves_of_many_references_become_nodes() {
        for count in [1, 2, 8, 9, 100, 1000] {
            let boxes: Vec<Aabb> = (0..count).map(|at| cube((at % 7) as f32, 0.5)).collect();
            let bvh = Bvh {
                nodes: vec![BvhNode::leaf(cube(0.0, 6.5), 0, count)],
                references: (0..count).rev().collect(),
            };
            let nodes = nodes_of(&bvh, &boxes);
            let mut leaves = Vec::new();
            for (at, node) in nodes.iter().enumerate() {
                for (place, word) in node.children.iter().enumerate() {
                    match WideChild::unpack(*word) {
                        WideChild::Empty => assert!(node.bounds(place).is_empty()),
                        WideChild::Node(child) => {
                            assert!(child as usize > at + 3);
                            assert_eq!(node.bounds(place), nodes[child as usize - 3].around());
                        }
                        WideChild::Leaf(leaf) => {
                            assert_eq!(node.bounds(place), boxes[leaf as usize - 100]);
                            leaves.push(leaf - 100);
                        }
                    }
                }
            }
            leaves.sort_unstable();
            assert_eq!(leaves, (0..count).collect::<Vec<u32>>(), "each once");
        }
    }

    #[test]
    fn of_nothing_comes_a_root_without_children() {
        assert_eq!(nodes_of(&Bvh::default(), &[]), [WideNode::EMPTY]);
    }
}
