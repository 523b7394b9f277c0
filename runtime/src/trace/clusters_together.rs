//! Ways of bundles through the clusters of an instance of which not all is posed.

use super::{
    bundle::Bundle,
    context::{ClusterRoom, FlightContext, InsideRoom},
    flight::{Actor, Inside},
    fly::Departure,
    fuzzy_tree::FuzzyTree,
};
use crate::{
    cluster_frame::Way,
    posing::BundleWork,
    prepared::{ClusterState, PosedCluster},
    wide::{Bundled, GROUP, Part, WideStack, walk_together},
};
use restpose_formats::TreeKind;

/// Rays that are so few at a cluster that each goes on alone. A picture of a thousand foxes, a hundred rays to each, took 15 % longer
/// without it; with 24, one of 576 triangles in 10,000 rays took 40 % longer.
const FEW: u32 = 12;

impl Bundle<'_> {
    /// Traces these groups through the clusters of the instance at an index. False where the rays must go one by one.
    pub(super) fn enter_clusters<const ANY: bool>(
        &mut self,
        (actor, index): (Actor<'_>, u32),
        groups: u32,
        bundled: &mut Bundled,
        room: &mut InsideRoom,
        context: &mut FlightContext,
    ) -> bool {
        let Actor { asset, prepared, .. } = actor;
        let nodes = prepared.top_level.nodes();
        if asset.model().meta.tree != TreeKind::Wide || !bundled.is_narrow(&prepared.bounds(), asset.nodes_per_pose()) {
            return false;
        }
        let Some(together) = bundled.in_world(nodes) else {
            return false;
        };
        let level = self.scene.simd;
        let InsideRoom {
            stack,
            lone_stack,
            cluster: room,
            ..
        } = room;
        let mut work = BundleWork::default();
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => {
                    let posed = prepared.cluster(asset, leaf, &mut context.cluster.motions);
                    let tree = (actor, posed);
                    if !self.enter_cluster::<ANY>(tree, groups, bundled, (room, lone_stack), &mut work) {
                        let places = bundled.meeting(level, groups, &posed.1.frame.bounds_world);
                        let inside = Inside::Cluster(leaf);
                        self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
                    }
                }
                Part::Alone { node, places } => {
                    let inside = Inside::Node(node);
                    self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut &nodes[..], &together, bundled, stack, &mut visit);
        prepared.count_bundle(groups.count_ones() * GROUP as u32, &work);
        true
    }

    /// False where the rays must go one by one, the cluster being refitted.
    fn enter_cluster<const ANY: bool>(
        &mut self,
        (actor, (state, posed)): (Actor<'_>, (&ClusterState, &PosedCluster)),
        groups: u32,
        bundled: &mut Bundled,
        (room, lone_stack): (&mut ClusterRoom, &mut WideStack),
        work: &mut BundleWork,
    ) -> bool {
        let Way::Local(local) = &posed.frame.way else {
            return false;
        };
        if posed.refit_after != u32::MAX && state.refitted().is_worth_it(posed.refit_after) {
            return false;
        }
        let level = self.scene.simd;
        let ClusterRoom {
            stack,
            local: local_rays,
            path,
            rays,
        } = room;
        let bounds = &posed.frame.bounds_world;
        let mut tree = FuzzyTree::new(actor, state, posed, local, rays);
        let places = bundled.meeting(level, groups, bounds);
        let pays = places.count_ones() > FEW;
        let together = pays.then(|| bundled.in_cluster(level, groups, (local, bounds), local_rays));
        let Some((together, frame)) = together.flatten() else {
            work.lone += places.count_ones();
            self.alone_below::<ANY>(&mut tree, 0, places, bundled, lone_stack);
            return true;
        };
        work.clusters += 1;
        let mut nodes = tree.for_bundle(&frame, path);
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => {
                    work.triangles += 1;
                    self.test::<ANY>(actor.id, leaf, &tree.pose(level, leaf), groups, bundled);
                }
                Part::Alone { node, places } => {
                    work.lone += places.count_ones();
                    self.alone_below::<ANY>(&mut tree, node, places, bundled, lone_stack);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut nodes, &together, bundled, stack, &mut visit);
        true
    }
}
