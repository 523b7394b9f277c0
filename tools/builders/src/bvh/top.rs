use super::primitive::set_len;
use rayon::prelude::*;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{BvhContent, BvhNode};

/// A node of the upper levels, whose sub-trees are built apart.
#[derive(Clone, Copy, Debug)]
pub(super) enum TopNode {
    /// Two nodes behind this one, left and right.
    Inner([usize; 2]),
    /// The sub-tree of that number.
    Subtree(usize),
}

/// Joins sub-trees under `top`, whose first node is the root, as depth first building would have ordered the nodes. Boxes
/// of the upper levels are made from those below.
///
/// Sub-trees must be numbered from left to right, and their children's places count from their own roots.
pub(super) fn join_subtrees(top: &[TopNode], subtrees: &[Vec<BvhNode>], nodes: &mut Vec<BvhNode>) {
    let bounds = top_bounds(top, subtrees);
    // A root, and two nodes more for each inner one; the root of each sub-tree is one of these.
    let upper = top.len() - subtrees.len();
    let len = 1 + 2 * upper + subtrees.iter().map(|subtree| subtree.len() - 1).sum::<usize>();
    set_len(nodes, len, BvhNode::leaf(Aabb::EMPTY, 0, 0));
    let places = place_top(top, &bounds, subtrees, nodes);
    let mut jobs = Vec::with_capacity(subtrees.len());
    let (mut rest, mut begin) = (&mut nodes[..], 0);
    for (subtree, place) in subtrees.iter().zip(places) {
        let (_, behind) = rest.split_at_mut(place - begin);
        let (body, behind) = behind.split_at_mut(subtree.len() - 1);
        begin = place + body.len();
        rest = behind;
        jobs.push((body, &subtree[1..], place as u32 - 1));
    }
    jobs.into_par_iter().for_each(|(body, subtree, shift)| {
        for (node, row) in body.iter_mut().zip(subtree) {
            *node = shifted(*row, shift);
        }
    });
}

/// Writes the upper levels and the sub-trees' roots; where what is below each of those begins.
fn place_top(top: &[TopNode], bounds: &[Aabb], subtrees: &[Vec<BvhNode>], nodes: &mut [BvhNode]) -> Vec<usize> {
    let mut places = Vec::with_capacity(subtrees.len());
    let mut end = 1;
    let mut open = vec![(0, 0)];
    while let Some((node, place)) = open.pop() {
        match top[node] {
            TopNode::Inner([left, right]) => {
                nodes[place] = BvhNode::inner(bounds[node], end as u32);
                open.extend([(right, end + 1), (left, end)]);
                end += 2;
            }
            TopNode::Subtree(number) => {
                nodes[place] = shifted(subtrees[number][0], end as u32 - 1);
                places.push(end);
                end += subtrees[number].len() - 1;
            }
        }
    }
    places
}

/// The boxes of all nodes of `top`.
fn top_bounds(top: &[TopNode], subtrees: &[Vec<BvhNode>]) -> Vec<Aabb> {
    let mut bounds = vec![Aabb::EMPTY; top.len()];
    for (index, node) in top.iter().enumerate().rev() {
        bounds[index] = match *node {
            TopNode::Inner([left, right]) => bounds[left].union(bounds[right]),
            TopNode::Subtree(number) => subtrees[number][0].bounds(),
        };
    }
    bounds
}

/// A node whose children are `shift` further behind.
fn shifted(node: BvhNode, shift: u32) -> BvhNode {
    match node.content() {
        BvhContent::Inner { left } => BvhNode::inner(node.bounds(), left + shift),
        BvhContent::Leaf { .. } => node,
    }
}
