use super::Share;
use restpose_runtime::build::{Bvh, BvhContent};

/// Places of a wide node.
pub(super) const WIDTH: usize = 8;

/// What it takes to bring all that is below a binary node into some places of a wide node: the sum of the shares of the
/// nodes that are kept, and how many these are. Of equal sums fewer nodes are better.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Cost {
    shares: f64,
    nodes: u32,
}

impl Cost {
    const NONE: Self = Self { shares: 0.0, nodes: 0 };

    fn and(self, other: Self) -> Self {
        Self {
            shares: self.shares + other.shares,
            nodes: self.nodes + other.nodes,
        }
    }
}

/// For every node of a binary hierarchy with one box to a leaf: how what is below it is best brought into one to eight
/// places.
///
/// With i places for a node, its children get k and i − k of them, whichever k costs least, or it is kept as a wide node
/// that takes one. A node that is kept has eight places for its children and costs as often as a ray meets it. The costs of
/// leaves are the same in all trees.
///
/// Guarantee: no wide hierarchy that keeps some of the binary nodes and dissolves the others costs less, but for rounding.
///
/// Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, 2017: the
/// conversion of a binary hierarchy that is optimal by surface areas.
/// Differs: leaves hold one box.
#[derive(Debug)]
pub(super) struct Plan {
    cuts: Vec<[u8; WIDTH]>,
    /// Leaves below.
    counts: Vec<u32>,
}

impl Plan {
    pub(super) fn new(tree: &Bvh) -> Self {
        let share = Share::new(&tree.bounds());
        let mut costs = vec![[Cost::NONE; WIDTH - 1]; tree.nodes.len()];
        let mut plan = Self {
            cuts: vec![[0; WIDTH]; tree.nodes.len()],
            counts: vec![1; tree.nodes.len()],
        };
        // Children stand behind their parents.
        for (at, node) in tree.nodes.iter().enumerate().rev() {
            let BvhContent::Inner { left } = node.content() else {
                continue;
            };
            let [lower, upper] = [left as usize, left as usize + 1];
            plan.counts[at] = plan.counts[lower] + plan.counts[upper];
            let sides = [costs[lower], costs[upper]];
            let (below, cut) = best_cut(&sides, WIDTH);
            plan.cuts[at][WIDTH - 1] = cut;
            let kept = Cost {
                shares: share.of(&node.bounds()),
                nodes: 1,
            };
            let mut best = kept.and(below);
            costs[at][0] = best;
            for places in 2..WIDTH {
                let (dissolved, cut) = best_cut(&sides, places);
                if dissolved < best {
                    best = dissolved;
                    plan.cuts[at][places - 1] = cut;
                }
                costs[at][places - 1] = best;
            }
        }
        plan
    }

    /// Leaves below a node.
    pub(super) fn count(&self, node: u32) -> usize {
        self.counts[node as usize] as usize
    }

    /// Adds the nodes that stand in the places of a wide node made of `node`, from left to right: leaves, and inner nodes
    /// that are kept.
    pub(super) fn children(&self, tree: &Bvh, node: u32, out: &mut Vec<u32>) {
        self.fill(tree, node, WIDTH, out);
    }

    fn fill(&self, tree: &Bvh, node: u32, places: usize, out: &mut Vec<u32>) {
        let BvhContent::Inner { left } = tree.nodes[node as usize].content() else {
            out.push(node);
            return;
        };
        // Where no cut is better than with a place less, the next lower cut counts.
        let cuts = &self.cuts[node as usize][..places];
        match cuts.iter().rposition(|cut| *cut != 0) {
            Some(last) => {
                let cut = usize::from(cuts[last]);
                self.fill(tree, left, cut, out);
                self.fill(tree, left + 1, last + 1 - cut, out);
            }
            None => out.push(node),
        }
    }
}

/// The cheapest way to part `places` between two children, and how many the left one gets.
fn best_cut(sides: &[[Cost; WIDTH - 1]; 2], places: usize) -> (Cost, u8) {
    let cost = |cut: usize| sides[0][cut - 1].and(sides[1][places - cut - 1]);
    let mut best = (cost(1), 1);
    for cut in 2..places {
        let other = cost(cut);
        if other < best.0 {
            best = (other, cut as u8);
        }
    }
    best
}
