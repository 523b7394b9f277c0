//! Traversal: a hierarchy over the clusters' world boxes, and in each cluster that a ray enters, its fuzzy tree: a
//! kd-tree, or a wide one, some of whose boxes follow the pose.
//!
//! Inside, the ray is `origin + t·2^e·direction'` with the direction scaled by a power of two so that its longest
//! component is in [1, 2): `t` then measures lengths, whatever the caller's units, and error bounds in lengths hold.
//! Ranges of `t` are cut one `f32` outside the hit's own `t`, so that its rounding never hides a hit.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.2.3 (two levels, triangle tests in world space). Differs: every
//! plane is widened by the cluster's margin for the ray (see `cluster_frame`), so the children of a node overlap.

mod batch;
mod context;
mod mailbox;
mod moments;
mod ray_order;
mod traveller;
mod walk;

pub(crate) use batch::{Answer, trace_together};
pub(crate) use context::TraceContext;
pub(crate) use ray_order::{RayOrder, place};
pub(crate) use walk::Hierarchy;

use crate::{
    Asset, Hit, InstanceId, Ray,
    box_tree::BoxTree,
    cluster_frame::{LatticeRay, SlabRay, Way},
    instance::Instance,
    mover_maps::MOST_STEPS,
    prepared::{Prepared, Whole},
    refitted_tree::RefittedBoxes,
    scene::Scene,
    simd::SimdLevel,
    stats::Count,
    wide::{self, FuzzyRay, WideRay, WideStack},
};
use context::{ClusterContext, InstanceContext};
use mailbox::Mailbox;
use restpose_formats::TreeKind;
use std::ops::Range;
use traveller::Traveller;
use walk::{Level, walk, walk_hierarchy};

/// The closest hit, or any hit if `ANY`, at a time of the scene's interval from 0 to 1.
pub(crate) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    time: f32,
    context: &mut TraceContext,
    counters: &mut impl Count,
) -> Option<Hit> {
    trace_among::<ANY>(scene, ray, time, &|_| true, context, counters)
}

/// As [`trace`], among the instances for which `accept` is true.
pub(crate) fn trace_among<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    time: f32,
    accept: &impl Fn(InstanceId) -> bool,
    context: &mut TraceContext,
    counters: &mut impl Count,
) -> Option<Hit> {
    counters.ray();
    let (mut traveller, start) = Traveller::new(ray)?;
    let bounds = scene.top_level.bounds();
    if bounds.is_empty() {
        return None;
    }
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, &bounds);
    let TraceContext { stack, instance, .. } = context;
    wide::walk(
        scene.simd,
        scene.top_level.nodes(),
        0,
        &WideRay::new(&slab),
        start,
        &mut traveller,
        stack,
        counters,
        &mut |index, traveller, counters| {
            accept(scene.id(index)) && enter_instance::<ANY>(scene, index, time, start, traveller, instance, counters)
        },
    );
    traveller.best
}

/// Traverses one instance; true when the search is over.
fn enter_instance<const ANY: bool>(
    scene: &Scene,
    index: u32,
    time: f32,
    start: f32,
    traveller: &mut Traveller,
    context: &mut InstanceContext,
    counters: &mut impl Count,
) -> bool {
    counters.instance();
    let id = scene.id(index);
    let InstanceContext {
        stack,
        cluster,
        moments,
        ..
    } = context;
    match scene.in_slot(index) {
        None => false,
        Some(Instance::Geometry(geometry)) => {
            let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut _| {
                Count::triangle(counters);
                traveller.test(&geometry.posed_triangle(triangle), id, triangle) && ANY
            };
            let stack = &mut cluster.binary;
            walk_posed(geometry.tree(), start, traveller, stack, counters, &mut test)
        }
        Some(Instance::Asset(instance)) => {
            let actor = Actor {
                id,
                asset: instance.asset(),
                prepared: moments.prepared_at(scene, index, instance, time),
                simd: scene.simd,
            };
            let whole = actor.prepared.enter(instance.pool());
            if whole.is_some() {
                actor.prepared.count_whole(1);
            }
            match whole {
                Some(whole) if !whole.nodes.is_empty() => {
                    enter_whole::<ANY>(&actor, whole, start, traveller, stack, counters)
                }
                whole => {
                    let (is_whole, before) = (whole.is_some(), traveller.tests);
                    let is_over = enter_clusters::<ANY>(&actor, is_whole, start, traveller, (stack, cluster), counters);
                    if !is_whole {
                        actor.prepared.count(traveller.tests.wrapping_sub(before));
                    }
                    is_over
                }
            }
        }
    }
}

/// An instance that a ray is in.
struct Actor<'a> {
    id: InstanceId,
    asset: &'a Asset,
    prepared: &'a Prepared,
    simd: SimdLevel,
}

fn enter_whole<const ANY: bool>(
    actor: &Actor,
    whole: &Whole,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut WideStack,
    counters: &mut impl Count,
) -> bool {
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, &whole.nodes[0].around());
    let triangles = actor.asset.model().triangles;
    wide::walk(
        actor.simd,
        &whole.nodes,
        0,
        &WideRay::new(&slab),
        start,
        traveller,
        stack,
        counters,
        &mut |triangle, traveller, counters| {
            counters.triangle();
            let corners = triangles[triangle as usize].corners;
            let corners = corners.map(|corner| whole.positions[corner as usize]);
            traveller.test(&corners, actor.id, triangle) && ANY
        },
    )
}

fn enter_clusters<const ANY: bool>(
    actor: &Actor,
    is_whole: bool,
    start: f32,
    traveller: &mut Traveller,
    (stack, cluster): (&mut WideStack, &mut ClusterContext),
    counters: &mut impl Count,
) -> bool {
    let top_level = &actor.prepared.top_level;
    let slab = SlabRay::in_world(traveller.origin, traveller.direction, &top_level.bounds());
    wide::walk(
        actor.simd,
        top_level.nodes(),
        0,
        &WideRay::new(&slab),
        start,
        traveller,
        stack,
        counters,
        &mut |slot, traveller, counters| {
            enter_cluster::<ANY, _>(actor, slot, is_whole, start, traveller, cluster, counters)
        },
    )
}

fn enter_cluster<const ANY: bool, C: Count>(
    actor: &Actor,
    slot: u32,
    is_whole: bool,
    start: f32,
    traveller: &mut Traveller,
    context: &mut ClusterContext,
    counters: &mut C,
) -> bool {
    counters.cluster();
    let Actor {
        id,
        asset,
        prepared,
        simd,
    } = *actor;
    let ClusterContext { stack, binary, motions } = context;
    let (state, posed) = prepared.cluster(asset, slot, motions);
    let model = asset.model();
    let row = &model.clusters[state.row as usize];
    let (origin, direction) = (traveller.origin, traveller.direction);
    let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut C| {
        counters.triangle();
        let corners = prepared.pose_triangle(model, state.cache, triangle, counters);
        traveller.test(&corners, id, triangle) && ANY
    };
    let pose = |triangle| prepared.pose_triangle(model, state.cache, triangle, &mut ());
    let refit_after = if is_whole { 0 } else { posed.refit_after };
    let refitted = refit_after != u32::MAX && state.refitted().is_worth_it(refit_after);
    match (&posed.frame.way, model.meta.tree) {
        (Way::Posed(tree), _) => {
            let tree = &prepared.trees[*tree as usize];
            walk_posed(tree, start, traveller, binary, counters, &mut test)
        }
        (Way::Local(local), TreeKind::Wide) if !refitted => {
            let (slab, margin_posed) = local.enter(origin, direction, &posed.frame.bounds_world);
            if slab.clip(&row.bounds_local, (start, traveller.limit)).is_none() {
                return false;
            }
            let rest = asset.rest_lattice(state.row);
            let follows = SlabRay {
                margin: margin_posed,
                ..slab
            };
            let ray = FuzzyRay {
                fuzzy: LatticeRay::new(&slab, &row.bounds_local, asset.box_steps(state.row)),
                posed: LatticeRay::within(&follows, rest.origin, [rest.step; 3], MOST_STEPS),
                motions: &posed.movers,
                movers: model.node_movers,
            };
            let nodes = asset.wide_nodes(state.row);
            wide::walk(simd, nodes, 0, &ray, start, traveller, stack, counters, &mut test)
        }
        (Way::Local(_) | Way::Refitted, TreeKind::Wide) => {
            let nodes = state.refitted().wide(asset.wide_nodes(state.row), pose);
            let slab = SlabRay::in_world(origin, direction, &nodes[0].around());
            let ray = WideRay::new(&slab);
            wide::walk(simd, nodes, 0, &ray, start, traveller, stack, counters, &mut test)
        }
        (Way::Local(local), TreeKind::Kd) if !refitted => {
            let (slab, _) = local.enter(origin, direction, &posed.frame.bounds_world);
            let Some(range) = slab.clip(&row.bounds_local, (start, traveller.limit)) else {
                return false;
            };
            let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
            let references = &model.references[row.reference_first as usize..][..row.reference_count as usize];
            let boxes = &model.reference_boxes[row.reference_first as usize..][..row.reference_count as usize];
            let lattice = LatticeRay::new(&slab, &row.bounds_local, asset.box_steps(state.row));
            let mut mailbox = Mailbox::EMPTY;
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut C| {
                boxes[leaf.clone()]
                    .iter()
                    .zip(&references[leaf])
                    .any(|(bounds, triangle)| {
                        counters.fuzzy_box();
                        lattice.meets(bounds, (start, traveller.limit))
                            && mailbox.insert(*triangle)
                            && test(*triangle, traveller, counters)
                    })
            };
            walk(nodes, &slab, range, traveller, binary, counters, &mut visit)
        }
        (Way::Local(_) | Way::Refitted, TreeKind::Kd) => {
            let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
            let rows = row.reference_first as usize..(row.reference_first + row.reference_count) as usize;
            let references = &model.references[rows.clone()];
            let first = &asset.first_references()[rows];
            let boxes = state.refitted().boxes(nodes, references, first, pose);
            let tree = RefittedBoxes { nodes, boxes };
            let slab = SlabRay::in_world(origin, direction, &boxes[0]);
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut C| {
                let own = references[leaf.clone()].iter().zip(&first[leaf]);
                own.filter(|(_, first)| **first)
                    .any(|(triangle, _)| test(*triangle, traveller, counters))
            };
            walk_hierarchy(&tree, &slab, start, traveller, binary, counters, &mut visit)
        }
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
