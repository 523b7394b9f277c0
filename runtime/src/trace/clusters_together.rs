//! Ways of bundles through the clusters of an instance of which not all is posed.

use super::{
    bundle::Bundle,
    context::{ClusterRoom, FlightContext, InsideRoom},
    flight::{Actor, Inside},
    fly::Departure,
    fuzzy_tree::FuzzyTree,
    mailbox::Mailbox,
};
use crate::{
    cluster_frame::{LatticeRay, LocalFrame, Way},
    posing::BundleWork,
    prepared::{ClusterState, PosedCluster},
    set_bits::set_bits,
    wide::{Bundled, GROUP, KdSpace, PACKET, Part, WideStack, walk_together},
};
use restpose_formats::TreeKind;
use std::ops::Range;

/// Rays that are so few at a cluster that each goes on alone. A picture of a thousand foxes, a hundred rays to each, took 15 % longer
/// without it; with 24, one of 576 triangles in 10,000 rays took 40 % longer.
const FEW: u32 = 12;

/// A cluster that rays enter in its local space.
#[derive(Clone, Copy)]
struct Entered<'a> {
    actor: Actor<'a>,
    state: &'a ClusterState,
    posed: &'a PosedCluster,
    local: &'a LocalFrame,
}

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
        if !bundled.is_narrow(&prepared.bounds(), asset.nodes_per_pose()) {
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
            let (inside, places) = match part {
                Part::Leaf { leaf, groups } => {
                    let (state, posed) = prepared.cluster(asset, leaf, &mut context.cluster.motions);
                    let places = bundled.meeting(level, groups, &posed.frame.bounds_world);
                    let room = (&mut *room, &mut *lone_stack);
                    // A group costs about as much as a ray.
                    let entering = if places == 0 { 0 } else { groups.count_ones() };
                    let is_refitted =
                        posed.refit_after != u32::MAX && state.refitted().is_worth_it(posed.refit_after, entering);
                    let is_done = match &posed.frame.way {
                        Way::Local(local) if !is_refitted => {
                            let cluster = Entered {
                                actor,
                                state,
                                posed,
                                local,
                            };
                            self.enter_cluster::<ANY>(&cluster, (groups, places), bundled, room, &mut work)
                        }
                        _ => false,
                    };
                    (Inside::Cluster(leaf), if is_done { 0 } else { places })
                }
                Part::Alone { node, places } => (Inside::Node(node), places),
            };
            if places != 0 {
                self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
            }
            bundled.is_over()
        };
        walk_together(level, &mut &nodes[..], &together, bundled, stack, &mut visit);
        prepared.count_bundle(groups.count_ones() * GROUP as u32, &work);
        true
    }

    /// Traces those of these groups that meet the cluster. False where they must go one by one.
    fn enter_cluster<const ANY: bool>(
        &mut self,
        cluster: &Entered,
        (groups, places): (u32, u64),
        bundled: &mut Bundled,
        (room, lone_stack): (&mut ClusterRoom, &mut WideStack),
        work: &mut BundleWork,
    ) -> bool {
        let is_few = places.count_ones() <= FEW;
        match cluster.actor.asset.model().meta.tree {
            // Rays through a posed kd-tree go alone, so that posing would save these nothing.
            TreeKind::Kd => !is_few && self.walk_kd::<ANY>(cluster, groups, bundled, room),
            TreeKind::Wide => {
                if is_few || !self.walk_wide::<ANY>(cluster, groups, bundled, (room, lone_stack), work) {
                    work.lone += places.count_ones();
                    let mut tree = cluster.tree(&mut room.rays);
                    self.alone_below::<ANY>(&mut tree, 0, places, bundled, lone_stack);
                }
                true
            }
        }
    }

    /// False where they must go one by one.
    fn walk_wide<const ANY: bool>(
        &mut self,
        cluster: &Entered,
        groups: u32,
        bundled: &mut Bundled,
        (room, lone_stack): (&mut ClusterRoom, &mut WideStack),
        work: &mut BundleWork,
    ) -> bool {
        let level = self.scene.simd;
        let space = (cluster.local, &cluster.posed.frame.bounds_world);
        let Some((together, frame)) = bundled.in_cluster(level, groups, space, &mut room.local) else {
            return false;
        };
        work.clusters += 1;
        let mut tree = cluster.tree(&mut room.rays);
        let mut nodes = tree.for_bundle(&frame, &mut room.path);
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => {
                    work.triangles += 1;
                    self.pose_and_test::<ANY>(cluster, leaf, groups, bundled);
                }
                Part::Alone { node, places } => {
                    work.lone += places.count_ones();
                    self.alone_below::<ANY>(&mut tree, node, places, bundled, lone_stack);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut nodes, &together, bundled, &mut room.stack, &mut visit);
        true
    }

    /// False where they must go one by one.
    fn walk_kd<const ANY: bool>(
        &mut self,
        cluster: &Entered,
        groups: u32,
        bundled: &mut Bundled,
        room: &mut ClusterRoom,
    ) -> bool {
        let level = self.scene.simd;
        let (asset, row) = (cluster.actor.asset, cluster.state.row);
        let (model, rows) = (asset.model(), &asset.model().clusters[row as usize]);
        let space = (cluster.local, &cluster.posed.frame.bounds_world);
        let Some((together, frame)) = bundled.in_cluster(level, groups, space, &mut room.local) else {
            return false;
        };
        let [lattice, _] = asset.local_lattices(row, &frame);
        let space = KdSpace {
            nodes: &model.kd_nodes[rows.node_first as usize..][..rows.node_count as usize],
            bounds: &rows.bounds_local,
            together: &together,
            frame: &frame,
        };
        let own = rows.reference_first as usize..(rows.reference_first + rows.reference_count) as usize;
        let (references, boxes) = (&model.references[own.clone()], &model.reference_boxes[own]);
        for group in set_bits(groups.into()) {
            let mut mailbox = Mailbox::EMPTY;
            let mut visit = |leaf: Range<usize>, bundled: &mut Bundled| {
                for (bounds, triangle) in boxes[leaf.clone()].iter().zip(&references[leaf]) {
                    let bounds = lattice.widened_box(bounds);
                    if bundled.meeting_in(level, &together, 1 << group, &bounds) != 0 && mailbox.insert(*triangle) {
                        self.pose_and_test::<ANY>(cluster, *triangle, 1 << group, bundled);
                    }
                }
                bundled.is_over()
            };
            bundled.walk_kd(level, group, &space, &mut room.kd_stack, &mut visit);
        }
        true
    }

    fn pose_and_test<const ANY: bool>(&mut self, cluster: &Entered, triangle: u32, groups: u32, bundled: &mut Bundled) {
        let Actor { id, asset, prepared } = cluster.actor;
        let corners = prepared.pose_triangle_at(self.scene.simd, asset.model(), cluster.state.cache, triangle);
        self.test::<ANY>(id, triangle, &corners, groups, bundled);
    }
}

impl<'a> Entered<'a> {
    fn tree<'t>(&self, rays: &'t mut [[LatticeRay; 2]; PACKET]) -> FuzzyTree<'t>
    where
        'a: 't,
    {
        FuzzyTree::new(self.actor, self.state, self.posed, self.local, rays)
    }
}
