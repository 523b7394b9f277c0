//! Traversal: a hierarchy over the clusters' world boxes, and in each cluster that a ray enters, the kd-tree over its
//! fuzzy boxes.
//!
//! Inside, the ray is `origin + t·2^e·direction'` with the direction scaled by a power of two so that its longest
//! component is in [1, 2): `t` then measures lengths, whatever the caller's units, and error bounds in lengths hold.
//! Ranges of `t` are cut one `f32` outside the hit's own `t`, so that its rounding never hides a hit.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.2.3 (two levels, triangle tests in world space). Differs: every
//! plane is widened by the cluster's margin for the ray (see `cluster_frame`), so the children of a node overlap.

mod mailbox;
mod traveller;
mod walk;

pub(crate) use walk::{Hierarchy, Stack};

use crate::{
    Hit, Ray,
    asset_instance::{Active, AssetInstance},
    box_tree::BoxTree,
    cluster_frame::{LatticeRay, SlabRay, Way},
    instance::Instance,
    refitted_tree::RefittedBoxes,
    scene::{Entry, Scene},
    stats::Count,
};
use mailbox::Mailbox;
use std::ops::Range;
use traveller::Traveller;
use walk::{Level, walk, walk_hierarchy};

/// The closest hit, or any hit if `ANY`.
pub(crate) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    stack: &mut Stack,
    counters: &mut impl Count,
) -> Option<Hit> {
    counters.ray();
    let (mut traveller, start) = Traveller::new(ray)?;
    let bounds = scene.top_level.bounds();
    if bounds.is_empty() {
        return None;
    }
    let Stack([top_stack, cluster_stack]) = stack;
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, &bounds);
    let mut enter = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut _| {
        scene.top_level.leaf(leaf).any(|id| {
            slab.clip(&scene.boxes[id as usize], (start, traveller.limit))
                .is_some_and(|_| enter_cluster::<ANY>(scene, id, start, traveller, cluster_stack, counters))
        })
    };
    walk_hierarchy(
        &scene.top_level,
        &slab,
        start,
        &mut traveller,
        top_stack,
        counters,
        &mut enter,
    );
    traveller.best
}

/// Traverses one cluster; true when the search is over.
fn enter_cluster<const ANY: bool>(
    scene: &Scene,
    id: u32,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut impl Count,
) -> bool {
    counters.cluster();
    let Entry { instance, slot } = scene.entries[id as usize];
    match &scene.instances[instance as usize] {
        Instance::Geometry(geometry) => {
            let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut _| {
                Count::triangle(counters);
                traveller.test(&geometry.posed_triangle(triangle), instance, triangle) && ANY
            };
            walk_posed(geometry.tree(), start, traveller, stack, counters, &mut test)
        }
        Instance::Asset(state) => enter_asset_cluster::<ANY>(state, instance, slot, start, traveller, stack, counters),
    }
}

fn enter_asset_cluster<const ANY: bool>(
    state: &AssetInstance,
    instance: u32,
    slot: u32,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut impl Count,
) -> bool {
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
        traveller.test(&state.pose_triangle(*cache, triangle), instance, triangle) && ANY
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
            let tree = RefittedBoxes { nodes, boxes };
            let slab = SlabRay::in_world(traveller.origin, traveller.direction, &boxes[0]);
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut _| {
                let own = references[leaf.clone()].iter().zip(&first[leaf]);
                own.filter(|(_, first)| **first)
                    .any(|(triangle, _)| test(*triangle, traveller, counters))
            };
            walk_hierarchy(&tree, &slab, start, traveller, stack, counters, &mut visit)
        }
        Way::Posed(tree) => walk_posed(
            &state.trees[*tree as usize],
            start,
            traveller,
            stack,
            counters,
            &mut test,
        ),
    }
}

/// Traverses a tree over posed triangles; `test` says whether the search is over.
fn walk_posed<C: Count>(
    tree: &BoxTree,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut C,
    test: &mut impl FnMut(u32, &mut Traveller, &mut C) -> bool,
) -> bool {
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, &tree.bounds());
    let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut C| {
        tree.leaf(leaf).any(|triangle| test(triangle, traveller, counters))
    };
    walk_hierarchy(tree, &slab, start, traveller, stack, counters, &mut visit)
}
