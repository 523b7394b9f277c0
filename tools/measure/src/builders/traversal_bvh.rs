use super::traversal::Traveller;
use restpose_runtime::build::{Bvh, BvhContent, MAX_BVH_DEPTH};

/// A node that a ray may still visit, and where it enters it.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
}

/// Visits the leaves that the ray may touch, the nearer child first.
pub(super) fn trace(tree: &Bvh, start: f32, traveller: &mut Traveller) {
    let Some((enter, _)) = traveller.clip(&tree.bounds(), start) else {
        return;
    };
    // A node leaves at most one sibling behind per level.
    let mut stack = [Pending { node: 0, enter: 0.0 }; MAX_BVH_DEPTH + 1];
    let mut pending = 0;
    let mut next = Pending { node: 0, enter };
    loop {
        match tree.nodes[next.node as usize].content() {
            BvhContent::Inner { left } => {
                traveller.counts.steps += 1;
                let met = |node: u32| {
                    let range = traveller.clip(&tree.nodes[node as usize].bounds(), start);
                    range.map(|(enter, _)| Pending { node, enter })
                };
                match (met(left), met(left + 1)) {
                    (Some(a), Some(b)) => {
                        let (near, far) = if b.enter < a.enter { (b, a) } else { (a, b) };
                        stack[pending] = far;
                        pending += 1;
                        next = near;
                        continue;
                    }
                    (Some(only), None) | (None, Some(only)) => {
                        next = only;
                        continue;
                    }
                    (None, None) => {}
                }
            }
            BvhContent::Leaf { first, count } => {
                for triangle in &tree.references[first as usize..][..count as usize] {
                    traveller.test(*triangle);
                }
            }
        }
        loop {
            if pending == 0 {
                return;
            }
            pending -= 1;
            if stack[pending].enter <= traveller.limit {
                next = stack[pending];
                break;
            }
        }
    }
}
