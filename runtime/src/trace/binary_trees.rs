//! Ways through trees that are not wide, each in one step.

use super::{
    flight::Actor,
    mailbox::Mailbox,
    traveller::Traveller,
    walk::{Level, walk, walk_hierarchy},
};
use crate::{
    InstanceId,
    box_tree::BoxTree,
    cluster_frame::{LatticeRay, SlabRay, Way},
    geometry_instance::GeometryInstance,
    prepared::{ClusterState, PosedCluster},
    refitted_tree::RefittedBoxes,
    simd::Portable,
    stats::Count,
};
use restpose_formats::rows::ClusterRow;
use std::ops::Range;

/// Traverses a cluster's tree that is not wide; true when the search is over.
pub(super) fn pass_cluster<const ANY: bool, C: Count>(
    actor: Actor<'_>,
    (state, posed): (&ClusterState, &PosedCluster),
    refitted: bool,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut C,
) -> bool {
    let Actor { id, asset, prepared } = actor;
    let (origin, direction) = (traveller.origin, traveller.direction);
    let model = asset.model();
    let row: &ClusterRow = &model.clusters[state.row as usize];
    let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut C| {
        counters.triangle();
        let corners = prepared.pose_triangle(Portable, model, state.cache, triangle, counters);
        traveller.test(&corners, id, triangle) && ANY
    };
    if let Way::Posed(tree) = &posed.frame.way {
        let tree = prepared.trees[*tree as usize].binary();
        return walk_posed(tree, start, traveller, stack, counters, &mut test);
    }
    let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
    let rows = row.reference_first as usize..(row.reference_first + row.reference_count) as usize;
    match &posed.frame.way {
        Way::Local(local) if !refitted => {
            let (slab, _) = local.enter(origin, direction, &posed.frame.bounds_world);
            let Some(range) = slab.clip(&row.bounds_local, (start, traveller.limit)) else {
                return false;
            };
            let (references, boxes) = (&model.references[rows.clone()], &model.reference_boxes[rows]);
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
            walk(nodes, &slab, range, traveller, stack, counters, &mut visit)
        }
        _ => {
            let references = &model.references[rows.clone()];
            let first = &asset.first_references()[rows];
            let pose = |triangle| prepared.pose_triangle(Portable, model, state.cache, triangle, &mut ());
            let boxes = state.refitted().boxes(nodes, references, first, pose);
            let tree = RefittedBoxes { nodes, boxes };
            let slab = SlabRay::in_world(origin, direction, &boxes[0]);
            let mut visit = |leaf: Range<usize>, traveller: &mut Traveller, counters: &mut C| {
                let own = references[leaf.clone()].iter().zip(&first[leaf]);
                own.filter(|(_, first)| **first)
                    .any(|(triangle, _)| test(*triangle, traveller, counters))
            };
            walk_hierarchy(&tree, &slab, start, traveller, stack, counters, &mut visit)
        }
    }
}

/// Traverses geometry of the caller's; true when the search is over.
pub(super) fn pass_geometry<const ANY: bool, C: Count>(
    geometry: &GeometryInstance,
    id: InstanceId,
    start: f32,
    traveller: &mut Traveller,
    stack: &mut Level,
    counters: &mut C,
) -> bool {
    let mut test = |triangle: u32, traveller: &mut Traveller, counters: &mut C| {
        Count::triangle(counters);
        traveller.test(&geometry.posed_triangle(triangle), id, triangle) && ANY
    };
    walk_posed(geometry.binary_tree(), start, traveller, stack, counters, &mut test)
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
