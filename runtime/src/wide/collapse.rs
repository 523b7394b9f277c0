#[cfg(feature = "parallel")]
use super::append_nodes;
use super::{WideNode, stack::MOST_NODES};
use crate::{
    Aabb,
    build::{Bvh, BvhContent},
};
use restpose_formats::rows::WideChild;

/// Trees with more references are collapsed in tasks, from the third level on.
#[cfg(feature = "parallel")]
const TASK_REFERENCES: usize = 4096;

/// Part of a binary tree that is to be a node, and where it is a child.
#[derive(Clone, Copy)]
struct Pending {
    content: BvhContent,
    parent: u32,
    place: u32,
}

impl Pending {
    const NONE: Self = Self {
        content: BvhContent::Leaf { first: 0, count: 0 },
        parent: 0,
        place: 0,
    };
}

/// A binary tree, the boxes that it was built over, and what its references are called.
struct Source<'a, F> {
    bvh: &'a Bvh,
    boxes: &'a [Aabb],
    leaf: F,
}

/// Appends a wide tree to `nodes` that has a leaf for each reference of `bvh`, called what `leaf` makes of it, and returns
/// the index of its root. A tree without nodes becomes a root without children.
///
/// `boxes` are those that the tree was built over. Each node opens the part with the largest area until it has eight. Nodes stand
/// depth first, which keeps near in memory what is near in space; with the feature `parallel`, those of large trees only from the
/// third level on.
///
/// Based on: Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008, §3.1 (collapsing by surface area).
pub(crate) fn collapse(bvh: &Bvh, boxes: &[Aabb], leaf: impl Fn(u32) -> u32 + Sync, nodes: &mut Vec<WideNode>) -> u32 {
    let root = nodes.len() as u32;
    let source = Source { bvh, boxes, leaf };
    let Some(top) = bvh.nodes.first() else {
        nodes.push(WideNode::EMPTY);
        return root;
    };
    #[cfg(feature = "parallel")]
    if bvh.references.len() > TASK_REFERENCES {
        source.collapse_in_tasks(top.content(), nodes);
        return root;
    }
    source.collapse_below(top.content(), nodes);
    root
}

impl<F: Fn(u32) -> u32> Source<'_, F> {
    /// Appends a part's tree.
    fn collapse_below(&self, content: BvhContent, nodes: &mut Vec<WideNode>) {
        let root = nodes.len();
        // Each node on the way down leaves seven parts behind.
        let mut pending = [Pending::NONE; 7 * MOST_NODES + 1];
        pending[0].content = content;
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let own = pending[count];
            let at = nodes.len();
            if at > root {
                nodes[own.parent as usize].children[own.place as usize] = WideChild::Node(at as u32).pack();
            }
            nodes.push(self.node(own.content, |place, content| {
                pending[count] = Pending {
                    content,
                    parent: at as u32,
                    place,
                };
                count += 1;
            }));
        }
    }

    /// The node of a part; `inner` is told which places are to be nodes.
    #[inline]
    fn node(&self, content: BvhContent, mut inner: impl FnMut(u32, BvhContent)) -> WideNode {
        let mut node = WideNode::EMPTY;
        let parts = self.open(content);
        // The first part is the next node, as in the binary tree.
        for place in (0..parts.count).rev() {
            node.set_bounds(place, &parts.bounds[place]);
            match parts.contents[place] {
                BvhContent::Leaf { first, count: 1 } => {
                    let reference = self.bvh.references[first as usize];
                    node.children[place] = WideChild::Leaf((self.leaf)(reference)).pack();
                }
                content => inner(place as u32, content),
            }
        }
        node
    }

    /// The parts of a node.
    #[inline]
    fn open(&self, content: BvhContent) -> Parts {
        let mut parts = Parts::NONE;
        match content {
            // The box of a single reference is its own; that of a part which is opened does not matter.
            BvhContent::Leaf { first, count: 1 } => {
                let reference = self.bvh.references[first as usize];
                parts.set(0, self.boxes[reference as usize], content);
            }
            _ => parts.set(0, Aabb::EVERYTHING, content),
        }
        parts.count = 1;
        while parts.count < 8
            && let Some(largest) = parts.largest()
        {
            let [(a, one), (b, other)] = self.halves(parts.contents[largest]);
            parts.set(largest, a, one);
            parts.set(parts.count, b, other);
            parts.count += 1;
        }
        parts
    }

    /// The two halves of a part with more than one reference: the children of an inner node, or the halves of a leaf's
    /// references.
    #[inline]
    fn halves(&self, content: BvhContent) -> [(Aabb, BvhContent); 2] {
        match content {
            BvhContent::Inner { left } => {
                let [a, b] = [left, left + 1].map(|child| &self.bvh.nodes[child as usize]);
                [(a.bounds(), a.content()), (b.bounds(), b.content())]
            }
            BvhContent::Leaf { first, count } => {
                let half = count / 2;
                [(first, half), (first + half, count - half)].map(|(first, count)| {
                    let references = &self.bvh.references[first as usize..][..count as usize];
                    let own = |reference: &u32| self.boxes[*reference as usize];
                    let bounds = match references {
                        [reference] => own(reference),
                        _ => references.iter().map(own).fold(Aabb::EMPTY, Aabb::union),
                    };
                    (bounds, BvhContent::Leaf { first, count })
                })
            }
        }
    }
}

#[cfg(feature = "parallel")]
impl<F: Fn(u32) -> u32 + Sync> Source<'_, F> {
    /// As [`Self::collapse_below`], but that the first levels stand before all others.
    fn collapse_in_tasks(&self, content: BvhContent, nodes: &mut Vec<WideNode>) {
        use rayon::prelude::*;
        let mut level = vec![Pending {
            content,
            ..Pending::NONE
        }];
        for depth in 0..2 {
            let mut below = Vec::new();
            for own in level {
                let at = nodes.len() as u32;
                if depth > 0 {
                    nodes[own.parent as usize].children[own.place as usize] = WideChild::Node(at).pack();
                }
                nodes.push(self.node(own.content, |place, content| {
                    below.push(Pending {
                        content,
                        parent: at,
                        place,
                    });
                }));
            }
            level = below;
        }
        // The same nodes in the same places, without a copy.
        if rayon::current_num_threads() == 1 {
            for own in level {
                nodes[own.parent as usize].children[own.place as usize] = WideChild::Node(nodes.len() as u32).pack();
                self.collapse_below(own.content, nodes);
            }
            return;
        }
        let trees: Vec<Vec<WideNode>> = level
            .par_iter()
            .map(|own| {
                let mut tree = Vec::new();
                self.collapse_below(own.content, &mut tree);
                tree
            })
            .collect();
        for (own, tree) in level.iter().zip(&trees) {
            let at = append_nodes(nodes, tree);
            nodes[own.parent as usize].children[own.place as usize] = WideChild::Node(at).pack();
        }
    }
}

/// Parts of a binary tree that are to stand in a node's places.
struct Parts {
    bounds: [Aabb; 8],
    contents: [BvhContent; 8],
    /// Half of their areas, as they compare; negative where they cannot be opened.
    areas: [f32; 8],
    count: usize,
}

impl Parts {
    const NONE: Self = Self {
        bounds: [Aabb::EMPTY; 8],
        contents: [BvhContent::Leaf { first: 0, count: 0 }; 8],
        areas: [-1.0; 8],
        count: 0,
    };

    #[inline]
    fn set(&mut self, place: usize, bounds: Aabb, content: BvhContent) {
        let [x, y, z] = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]);
        self.bounds[place] = bounds;
        self.contents[place] = content;
        self.areas[place] = match content {
            BvhContent::Leaf { count: 0 | 1, .. } => -1.0,
            // An infinite side times zero is no number, which counts as the least.
            _ => (x * y + y * z + z * x).max(0.0),
        };
    }

    /// The first of the largest that can be opened.
    #[inline]
    fn largest(&self) -> Option<usize> {
        let (mut largest, mut found) = (-1.0, None);
        for place in 0..self.count {
            if self.areas[place] > largest {
                (largest, found) = (self.areas[place], Some(place));
            }
        }
        found
    }
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
