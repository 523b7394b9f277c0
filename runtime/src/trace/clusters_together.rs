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
    wide::{Bundled, GROUP, Part, WideStack, walk_together},
};
use restpose_formats::TreeKind;

impl Bundle<'_> {
    /// False where the rays must go one by one.
    pub(super) fn enter_clusters<const ANY: bool>(
        &mut self,
        actor: Actor<'_>,
        index: u32,
        groups: u32,
        bundled: &mut Bundled,
        room: &mut InsideRoom,
        context: &mut FlightContext,
    ) -> bool {
        let level = self.scene.simd;
        let Actor { asset, prepared, .. } = actor;
        let nodes = prepared.top_level.nodes();
        if asset.model().meta.tree != TreeKind::Wide
            || !bundled.is_narrow(groups, &prepared.bounds(), asset.nodes_per_pose())
        {
            return false;
        }
        let Some(together) = bundled.in_world(nodes) else {
            return false;
        };
        let InsideRoom {
            stack,
            lone_stack,
            cluster: room,
            ..
        } = room;
        let mut work = 0;
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => {
                    let tests =
                        self.enter_cluster::<ANY>(actor, (index, leaf), groups, bundled, (room, lone_stack), context);
                    work += tests;
                }
                Part::Alone { node, places } => {
                    let inside = Inside::Node(node);
                    self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut &nodes[..], &together, bundled, stack, &mut visit);
        prepared.count_bundle(groups.count_ones() * GROUP as u32, work);
        true
    }

    /// How many triangles were posed.
    fn enter_cluster<const ANY: bool>(
        &mut self,
        actor: Actor<'_>,
        (index, slot): (u32, u32),
        groups: u32,
        bundled: &mut Bundled,
        (room, lone_stack): (&mut ClusterRoom, &mut WideStack),
        context: &mut FlightContext,
    ) -> u32 {
        let level = self.scene.simd;
        let Actor { id, asset, prepared } = actor;
        let (state, posed) = prepared.cluster(asset, slot, &mut context.cluster.motions);
        let is_refitted = posed.refit_after != u32::MAX && state.refitted().is_worth_it(posed.refit_after);
        let Way::Local(local) = &posed.frame.way else {
            return self.alone_in_cluster::<ANY>((index, slot), groups, bundled, &posed.frame.bounds_world, context);
        };
        if is_refitted {
            return self.alone_in_cluster::<ANY>((index, slot), groups, bundled, &posed.frame.bounds_world, context);
        }
        let ClusterRoom {
            stack,
            local: local_rays,
            path,
            rays,
        } = room;
        let mut tree = FuzzyTree::new(actor, state, posed, local, rays);
        let Some((together, frame)) = bundled.in_cluster(level, groups, (local, tree.bounds_world), local_rays) else {
            let places = bundled.meeting(level, groups, tree.bounds_world);
            self.alone_below::<ANY>(&mut tree, 0, places, bundled, lone_stack);
            return 0;
        };
        let mut nodes = tree.for_bundle(&frame, path);
        let mut work = 3;
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => {
                    work += 1;
                    self.test::<ANY>(id, leaf, &tree.pose(level, leaf), groups, bundled);
                }
                Part::Alone { node, places } => {
                    work += 4 * places.count_ones();
                    self.alone_below::<ANY>(&mut tree, node, places, bundled, lone_stack);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut nodes, &together, bundled, stack, &mut visit);
        work
    }

    fn alone_in_cluster<const ANY: bool>(
        &mut self,
        (index, slot): (u32, u32),
        groups: u32,
        bundled: &mut Bundled,
        bounds_world: &crate::Aabb,
        context: &mut FlightContext,
    ) -> u32 {
        let places = bundled.meeting(self.scene.simd, groups, bounds_world);
        let inside = Inside::Cluster(slot);
        self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
        0
    }
}
