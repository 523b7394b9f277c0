//! Traversal: a kd-tree over the clusters' world boxes, and in each cluster that a ray enters, the kd-tree over its
//! fuzzy boxes.
//!
//! Inside, the ray is `origin + t·2^e·direction'` with the direction scaled by a power of two so that its longest
//! component is in [1, 2): `t` then measures lengths, whatever the caller's units, and error bounds in lengths hold.
//! Ranges of `t` are cut one `f32` outside the hit's own `t`, so that its rounding never hides a hit.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.2.3 (two levels, triangle tests in world space). Differs: every
//! plane is widened by the cluster's margin for the ray (see `cluster_frame`), so the children of a node overlap.

use crate::{
    Aabb, Hit, InstanceId, Ray,
    cluster_frame::{LatticeRay, SlabRay, Way},
    instance::{Active, Instance},
    scene::{Entry, Scene},
    stats::Count,
    triangle::PreparedRay,
};
use restpose_formats::{
    geom::round::{f32_above, f32_below},
    rows::{KdNode, KdNodeRow, MAX_KD_DEPTH},
};
use std::ops::Range;

/// How many primitives a ray remembers as already tested. A miss in this memory costs a repeated test, no more.
const MAILBOX_SIZE: usize = 8;

/// The last few primitives that a ray has tested.
struct Mailbox {
    ids: [u32; MAILBOX_SIZE],
    next: usize,
}

impl Mailbox {
    const EMPTY: Self = Self {
        ids: [u32::MAX; MAILBOX_SIZE],
        next: 0,
    };

    /// True the first time; `id` must not be `u32::MAX`.
    #[inline]
    fn insert(&mut self, id: u32) -> bool {
        let known = self.ids.iter().fold(false, |known, other| known | (*other == id));
        if !known {
            self.ids[self.next] = id;
            self.next = (self.next + 1) % MAILBOX_SIZE;
        }
        !known
    }
}

#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

/// Scratch of a traversal: one kd-tree's worth of pending nodes per level.
pub(crate) struct Stack([[Pending; MAX_KD_DEPTH]; 2]);

impl Stack {
    pub(crate) const fn new() -> Self {
        Self(
            [[Pending {
                node: 0,
                enter: 0.0,
                exit: 0.0,
            }; MAX_KD_DEPTH]; 2],
        )
    }
}

/// A ray on its way through the scene.
struct Traveller {
    prepared: PreparedRay,
    origin: [f32; 3],
    /// Scaled.
    direction: [f32; 3],
    /// Scaled `t` is `t` times this.
    scale: f64,
    best: Option<Hit>,
    /// Scaled `t` beyond which no box matters.
    limit: f32,
}

impl Traveller {
    fn new(ray: &Ray) -> Option<(Self, f32)> {
        let prepared = PreparedRay::new(ray)?;
        let longest = ray.direction.iter().fold(0.0f32, |longest, d| longest.max(d.abs()));
        // Every nonzero f32 is a normal f64, so its exponent bits are its magnitude.
        let exponent = i64::try_from(f64::from(longest).to_bits() >> 52).ok()? - 1023;
        let power = |e: i64| f64::from_bits(((1023 + e) as u64) << 52);
        let direction = ray.direction.map(|d| (f64::from(d) * power(-exponent)) as f32);
        let scale = power(exponent);
        let start = f32_below(f64::from(ray.t_min.next_down()) * scale);
        let mut out = Self {
            prepared,
            origin: ray.origin,
            direction,
            scale,
            best: None,
            limit: f32::INFINITY,
        };
        out.limit = out.limit_behind(ray.t_max);
        Some((out, start))
    }

    fn limit_behind(&self, t: f32) -> f32 {
        f32_above(f64::from(t.next_up()) * self.scale)
    }

    /// Poses and tests one triangle; true when it is the best hit so far.
    #[inline]
    fn test(&mut self, state: &Instance, cache: u32, instance: u32, triangle: u32) -> bool {
        let corners = state.pose_triangle(cache, triangle);
        let Some(found) = self.prepared.intersect(&corners) else {
            return false;
        };
        let hit = Hit {
            t: found.t,
            u: found.u,
            v: found.v,
            instance: InstanceId(instance),
            triangle,
        };
        if self.best.as_ref().is_some_and(|best| !hit.is_before(best)) {
            return false;
        }
        self.best = Some(hit);
        self.limit = self.limit_behind(hit.t);
        true
    }
}

/// The closest hit, or any hit if `ANY`.
pub(crate) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    stack: &mut Stack,
    counters: &mut impl Count,
) -> Option<Hit> {
    counters.ray();
    let (mut traveller, start) = Traveller::new(ray)?;
    let bounds = &scene.top_level.bounds;
    if bounds.is_empty() {
        return None;
    }
    let Stack([top_stack, cluster_stack]) = stack;
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, bounds);
    let range = slab.clip(bounds, (start, traveller.limit))?;
    let mut mailbox = Mailbox::EMPTY;
    walk(
        &scene.top_level.nodes,
        &slab,
        range,
        &mut traveller,
        top_stack,
        counters,
        &mut |leaf, traveller, counters| {
            for id in &scene.top_level.references[leaf] {
                let done = mailbox.insert(*id)
                    && slab
                        .clip(&scene.boxes[*id as usize], (start, traveller.limit))
                        .is_some_and(|_| enter_cluster::<ANY>(scene, *id, start, traveller, cluster_stack, counters));
                if done {
                    return true;
                }
            }
            false
        },
    );
    traveller.best
}

/// Traverses one cluster; true when the search is over.
fn enter_cluster<const ANY: bool>(
    scene: &Scene,
    id: u32,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut [Pending; MAX_KD_DEPTH],
    counters: &mut impl Count,
) -> bool {
    counters.cluster();
    let Entry { instance, slot } = scene.entries[id as usize];
    let state = &scene.instances[instance as usize];
    let Active {
        row: number,
        cache,
        frame,
        excess: _,
        refit_after,
    } = &state.clusters[slot as usize];
    let model = state.asset.model();
    let row = &model.clusters[*number as usize];
    let references = &model.references[row.reference_first as usize..][..row.reference_count as usize];
    let mut mailbox = Mailbox::EMPTY;
    let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut _| {
        if !mailbox.insert(triangle) {
            return false;
        }
        Count::triangle(counters);
        traveller.test(state, *cache, instance, triangle) && ANY
    };
    let refitted = *refit_after != u32::MAX && state.refitted[*number as usize].is_worth_it(*refit_after);
    match &frame.way {
        Way::Local(local) if !refitted => {
            let slab = local.enter(traveller.origin, traveller.direction, &frame.bounds_world);
            let Some(range) = slab.clip(&row.bounds_local, (start, traveller.limit)) else {
                return false;
            };
            let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
            let boxes = &model.reference_boxes[row.reference_first as usize..][..row.reference_count as usize];
            let lattice = LatticeRay::new(&slab, &row.bounds_local, state.asset.box_steps(*number));
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut _| {
                boxes[leaf.clone()]
                    .iter()
                    .zip(&references[leaf])
                    .any(|(bounds, triangle)| {
                        Count::fuzzy_box(counters);
                        lattice.meets(bounds, (start, traveller.limit)) && test(*triangle, traveller, counters)
                    })
            };
            walk(nodes, &slab, range, traveller, stack, counters, &mut visit)
        }
        Way::Local(_) | Way::Refitted => {
            let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
            let rows = row.reference_first as usize..;
            let first = &state.asset.first_references()[rows][..references.len()];
            let pose = |triangle| state.pose_triangle(*cache, triangle);
            let boxes = state.refitted[*number as usize].boxes(nodes, references, first, pose);
            let slab = SlabRay::in_world(traveller.origin, traveller.direction, &boxes[0]);
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut _| {
                let own = references[leaf.clone()].iter().zip(&first[leaf]);
                own.filter(|(_, first)| **first)
                    .any(|(triangle, _)| test(*triangle, traveller, counters))
            };
            walk_boxes(nodes, boxes, &slab, start, traveller, stack, counters, &mut visit)
        }
        Way::Posed(tree) => {
            let tree = &state.trees[*tree as usize];
            let slab = SlabRay::in_world(traveller.origin, traveller.direction, &frame.bounds_world);
            let Some(range) = slab.clip(&frame.bounds_world, (start, traveller.limit)) else {
                return false;
            };
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut _| {
                tree.leaf(leaf).any(|(triangle, bounds)| {
                    Count::fuzzy_box(counters);
                    slab.clip(bounds, (start, traveller.limit)).is_some() && test(triangle, traveller, counters)
                })
            };
            walk(tree.nodes(), &slab, range, traveller, stack, counters, &mut visit)
        }
    }
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

/// Visits the leaves that the ray may touch within `range`, near ones first, until one says that the search is over.
fn walk<C: Count>(
    nodes: &[KdNodeRow],
    ray: &SlabRay,
    range: (f32, f32),
    traveller: &mut Traveller,
    stack: &mut [Pending; MAX_KD_DEPTH],
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

/// As [`walk`], where each node has a box in place of a cell.
#[expect(clippy::too_many_arguments, reason = "what `walk` takes, and the boxes")]
fn walk_boxes<C: Count>(
    nodes: &[KdNodeRow],
    boxes: &[Aabb],
    ray: &SlabRay,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut [Pending; MAX_KD_DEPTH],
    counters: &mut C,
    visit: &mut impl FnMut(Range<usize>, &mut Traveller, &mut C) -> bool,
) -> bool {
    let enter = |node: u32, traveller: &Traveller| ray.clip(&boxes[node as usize], (start, traveller.limit));
    if enter(0, traveller).is_none() {
        return false;
    }
    let (mut node, mut pending) = (0, 0);
    loop {
        match nodes[node as usize].unpack() {
            KdNode::Inner { left, .. } => {
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
        node = next.node;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mailbox_remembers_the_last_few() {
        let mut mailbox = Mailbox::EMPTY;
        for id in 0..MAILBOX_SIZE as u32 {
            assert!(mailbox.insert(id) && !mailbox.insert(id));
        }
        assert!(!mailbox.insert(0), "still within the memory");
        assert!(mailbox.insert(99) && mailbox.insert(0), "the oldest is forgotten");
    }

    #[test]
    fn directions_are_scaled_exactly() {
        for longest in [
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            1e-30,
            0.75,
            1.0,
            3.0,
            1e30,
            f32::MAX,
        ] {
            let (traveller, start) = Traveller::new(&Ray::new([0.0; 3], [longest, -longest / 2.0, 0.0])).unwrap();
            let d = traveller.direction[0];
            assert!((1.0..2.0).contains(&d), "{longest}: {d}");
            assert_eq!(f64::from(d) * traveller.scale, f64::from(longest));
            assert!(start < 0.0 && traveller.limit == f32::INFINITY);
        }
    }

    #[test]
    fn limit_lies_behind_the_hit() {
        let (traveller, _) = Traveller::new(&Ray::new([0.0; 3], [1e38, 0.0, 0.0])).unwrap();
        for t in [0.0, f32::from_bits(1), 1e-40, 1.0] {
            assert!(
                f64::from(traveller.limit_behind(t)) > f64::from(t) * traveller.scale,
                "{t}"
            );
        }
    }
}
