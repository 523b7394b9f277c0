use super::traveller::Traveller;
use crate::{
    Aabb,
    build::{BvhContent, MAX_BVH_DEPTH},
    cluster_frame::SlabRay,
    stats::Count,
};
use restpose_formats::rows::{KdNode, KdNodeRow, MAX_KD_DEPTH};
use std::ops::Range;

/// Each inner node above the present one leaves at most one sibling to come back to.
const STACK_SIZE: usize = if MAX_BVH_DEPTH > MAX_KD_DEPTH {
    MAX_BVH_DEPTH
} else {
    MAX_KD_DEPTH
};

#[derive(Clone, Copy)]
pub(super) struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

/// Takes the last of the pending nodes that begins before `limit`.
#[inline]
fn next_pending(stack: &[Pending], pending: &mut usize, limit: f32) -> Option<Pending> {
    while *pending > 0 {
        *pending -= 1;
        if stack[*pending].enter <= limit {
            return Some(stack[*pending]);
        }
    }
    None
}

/// Room for the pending nodes of a tree.
pub(super) type Level = [Pending; STACK_SIZE];

pub(super) const EMPTY_LEVEL: Level = [Pending {
    node: 0,
    enter: 0.0,
    exit: 0.0,
}; STACK_SIZE];

/// Visits the leaves that the ray may touch within `range`, near ones first, until one says that the search is over.
pub(super) fn walk<C: Count>(
    nodes: &[KdNodeRow],
    ray: &SlabRay,
    range: (f32, f32),
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut C,
    visit: &mut impl FnMut(Range<usize>, &mut Traveller, &mut C) -> bool,
) -> bool {
    let mut pending = 0;
    let (mut node, (mut enter, mut exit)) = (0u32, range);
    loop {
        match nodes[node as usize].unpack() {
            KdNode::Inner { axis, split, left } => {
                counters.step();
                let relative = split - ray.origin[axis];
                let inverse = ray.inverse_direction[axis];
                let below = (relative - ray.margin[axis]) * inverse;
                let above = (relative + ray.margin[axis]) * inverse;
                let (near, far, far_enter, near_exit) = if inverse.is_sign_positive() {
                    (left, left + 1, below, above)
                } else {
                    (left + 1, left, above, below)
                };
                // A NaN (the ray runs in a plane, or a margin overflowed) restricts neither child.
                let near_exit = if near_exit < exit { near_exit } else { exit };
                let far_enter = if far_enter > enter { far_enter } else { enter };
                let (visit_near, visit_far) = (enter <= near_exit, far_enter <= exit);
                if visit_near {
                    if visit_far {
                        stack[pending] = Pending {
                            node: far,
                            enter: far_enter,
                            exit,
                        };
                        pending += 1;
                    }
                    (node, exit) = (near, near_exit);
                    continue;
                } else if visit_far {
                    (node, enter) = (far, far_enter);
                    continue;
                }
            }
            KdNode::Leaf { first, count } => {
                let leaf = first as usize..first as usize + count as usize;
                if visit(leaf, traveller, counters) {
                    return true;
                }
            }
        }
        let Some(next) = next_pending(stack, &mut pending, traveller.limit) else {
            return false;
        };
        (node, enter, exit) = (next.node, next.enter, next.exit.min(traveller.limit));
    }
}

/// A tree of boxes in world space; its root is node 0.
pub(crate) trait Hierarchy {
    fn bounds(&self, node: u32) -> Aabb;
    fn content(&self, node: u32) -> BvhContent;
}

/// As [`walk`], where each node has a box in place of a cell.
pub(super) fn walk_hierarchy<C: Count>(
    tree: &impl Hierarchy,
    ray: &SlabRay,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut C,
    visit: &mut impl FnMut(Range<usize>, &mut Traveller, &mut C) -> bool,
) -> bool {
    let enter = |node: u32, traveller: &Traveller| ray.clip(&tree.bounds(node), (start, traveller.limit));
    if enter(0, traveller).is_none() {
        return false;
    }
    let (mut node, mut pending) = (0, 0);
    loop {
        match tree.content(node) {
            BvhContent::Inner { left } => {
                counters.step();
                let [a, b] = [left, left + 1].map(|child| enter(child, traveller).map(|(enter, _)| (child, enter)));
                let (near, far) = match (a, b) {
                    (Some(a), Some(b)) if b.1 < a.1 => (Some(b), Some(a)),
                    (None, b) => (b, None),
                    (a, b) => (a, b),
                };
                if let Some((far, enter)) = far {
                    stack[pending] = Pending {
                        node: far,
                        enter,
                        exit: f32::INFINITY,
                    };
                    pending += 1;
                }
                if let Some((near, _)) = near {
                    node = near;
                    continue;
                }
            }
            BvhContent::Leaf { first, count } => {
                let leaf = first as usize..first as usize + count as usize;
                if visit(leaf, traveller, counters) {
                    return true;
                }
            }
        }
        let Some(next) = next_pending(stack, &mut pending, traveller.limit) else {
            return false;
        };
        node = next.node;
    }
}
