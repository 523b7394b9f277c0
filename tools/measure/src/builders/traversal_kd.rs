use super::traversal::Traveller;
use restpose_formats::rows::{KdNode, MAX_KD_DEPTH};
use restpose_runtime::build::KdTree;

/// Triangles that a ray remembers as tested. One that is forgotten is tested again, no more.
const MAILBOX_SIZE: usize = 8;

/// A node that a ray may still visit, and its part of the ray.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

/// Visits the leaves that the ray may touch, the nearer child first. Planes are as wide as boxes are elsewhere.
pub(super) fn trace(tree: &KdTree, start: f32, traveller: &mut Traveller) {
    let Some((enter, exit)) = traveller.clip(&tree.bounds, start) else {
        return;
    };
    let nothing = Pending {
        node: 0,
        enter: 0.0,
        exit: 0.0,
    };
    let mut stack = [nothing; MAX_KD_DEPTH + 1];
    let mut pending = 0;
    let mut mailbox = [u32::MAX; MAILBOX_SIZE];
    let mut oldest = 0;
    let (mut node, mut enter, mut exit) = (0u32, enter, exit);
    loop {
        match tree.nodes[node as usize].unpack() {
            KdNode::Inner { axis, split, left } => {
                traveller.counts.steps += 1;
                let relative = split - traveller.origin[axis];
                let inverse = traveller.inverse_direction[axis];
                let below = (relative - traveller.margin) * inverse;
                let above = (relative + traveller.margin) * inverse;
                let (near, far, far_enter, near_exit) = if inverse.is_sign_positive() {
                    (left, left + 1, below, above)
                } else {
                    (left + 1, left, above, below)
                };
                // A NaN (the ray runs in the plane) restricts neither child.
                let near_exit = if near_exit < exit { near_exit } else { exit };
                let far_enter = if far_enter > enter { far_enter } else { enter };
                let (visit_near, visit_far) = (enter <= near_exit, far_enter <= exit);
                if visit_near && visit_far {
                    stack[pending] = Pending {
                        node: far,
                        enter: far_enter,
                        exit,
                    };
                    pending += 1;
                }
                if visit_near {
                    (node, exit) = (near, near_exit);
                    continue;
                } else if visit_far {
                    (node, enter) = (far, far_enter);
                    continue;
                }
            }
            KdNode::Leaf { first, count } => {
                for triangle in &tree.references[first as usize..][..count as usize] {
                    if !mailbox.contains(triangle) {
                        mailbox[oldest] = *triangle;
                        oldest = (oldest + 1) % MAILBOX_SIZE;
                        traveller.test(*triangle);
                    }
                }
            }
        }
        loop {
            if pending == 0 {
                return;
            }
            pending -= 1;
            if stack[pending].enter <= traveller.limit {
                let next = stack[pending];
                (node, enter, exit) = (next.node, next.enter, next.exit.min(traveller.limit));
                break;
            }
        }
    }
}
