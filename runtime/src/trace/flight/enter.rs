//! Ways into instances, clusters and their trees.

use super::{Actor, Flight, Inside, NEAR_TRIANGLES, Next, Tree};
use crate::{
    Asset, InstanceId,
    cluster_frame::{LocalFrame, SlabRay, Way},
    posed_mesh::PosedMesh,
    prepared::{ClusterState, PosedCluster, Whole},
    simd::{Lanes, Portable, prefetch},
    stats::Count,
    trace::{binary_trees::pass_cluster, context::ClusterContext},
    wide::{FuzzyRay, WideNode, WideRay, WideStack},
};
use restpose_formats::TreeKind;

impl<'a> Flight<'a> {
    /// The ray, ready for a tree in world space.
    #[inline(always)]
    pub(super) fn ray_in_world(&self, nodes: &[WideNode]) -> WideRay {
        let bounds = nodes[0].around();
        WideRay::new(&SlabRay::in_world(
            self.traveller.origin,
            self.traveller.direction,
            &bounds,
        ))
    }

    /// Enters a tree in world space.
    #[inline(always)]
    fn enter(&mut self, tree: Tree, nodes: &'a [WideNode]) {
        let ray = self.ray_in_world(nodes);
        self.tree = tree;
        self.world[tree.depth()] = (nodes, ray);
        self.floors[tree.depth()] = self.count;
        self.next = Next::MeetNode(0);
    }

    /// Enters a tree in world space in the next step: its root is asked for.
    #[inline(always)]
    fn enter_later(&mut self, tree: Tree, nodes: &'a [WideNode]) {
        prefetch(&nodes[..nodes.len().min(1)]);
        self.tree = tree;
        self.world[tree.depth()].0 = nodes;
        self.floors[tree.depth()] = self.count;
        self.next = Next::EnterRoot(0);
    }

    /// Enters an instance that is no geometry of the caller's.
    #[inline(always)]
    pub(in crate::trace) fn enter_actor(&mut self, actor: Actor<'a>, whole: Option<&'a Whole>) {
        (self.actor, self.is_whole) = (Some(actor), whole.is_some());
        // What instances share is near unless it is large. A refitted cluster's tree is as large as the one that they share.
        self.is_far[Tree::Fuzzy.depth()] = actor.asset.model().triangles.len() > NEAR_TRIANGLES;
        match whole {
            Some(whole) if !whole.nodes.is_empty() => {
                let triangles = actor.asset.model().triangles.len();
                self.is_far[Tree::Whole.depth()] = triangles.saturating_mul(whole.beside as usize) > NEAR_TRIANGLES;
                self.enter_later(Tree::Whole, &whole.nodes);
            }
            _ => {
                self.is_far[Tree::Clusters.depth()] = true;
                self.tests_before = self.traveller.tests;
                self.enter_later(Tree::Clusters, actor.prepared.top_level.nodes());
            }
        }
    }

    /// Enters geometry of the caller's.
    #[inline(always)]
    pub(in crate::trace) fn enter_geometry(&mut self, id: InstanceId, mesh: PosedMesh<'a>) {
        self.supplied = Some((id, mesh));
        self.is_far[Tree::Supplied.depth()] = mesh.triangles.len() > NEAR_TRIANGLES;
        self.enter_later(Tree::Supplied, mesh.nodes);
    }

    /// [`Self::enter_actor`], but for what is not inside of it. Where all of it has been posed meanwhile, that is all.
    #[inline(always)]
    pub(in crate::trace) fn enter_inside(&mut self, actor: Actor<'a>, whole: Option<&'a Whole>, inside: Inside) {
        self.enter_actor(actor, whole);
        match inside {
            _ if self.tree == Tree::Whole => {}
            Inside::All => {}
            Inside::Node(node) => self.next = Next::EnterRoot(node),
            Inside::Cluster(slot) => self.next = Next::EnterCluster(slot),
        }
    }

    /// Enters a cluster's tree, or where it is no wide one, comes back from there: true where the search is then over.
    #[inline(always)]
    pub(super) fn enter_cluster<const ANY: bool, C: Count>(
        &mut self,
        slot: u32,
        context: &mut ClusterContext,
        counters: &mut C,
    ) -> bool {
        counters.cluster();
        let Actor { asset, prepared, .. } = self.actor();
        let (state, posed) = prepared.cluster(asset, slot, &mut context.motions);
        self.cache = state.cache;
        let model = asset.model();
        if let Way::Posed(tree) = &posed.frame.way {
            let tree = &prepared.trees[*tree as usize];
            tree.count(1);
            if let Some(nodes) = tree.wide() {
                self.enter(Tree::Refitted, nodes);
                return false;
            }
        }
        let refit_after = if self.is_whole { 0 } else { posed.refit_after };
        let refitted = refit_after != u32::MAX && state.refitted().is_worth_it(refit_after, 1);
        match (&posed.frame.way, model.meta.tree) {
            (Way::Local(local), TreeKind::Wide) if !refitted => {
                self.enter_fuzzy(asset, state, posed, local);
                false
            }
            (Way::Local(_) | Way::Refitted, TreeKind::Wide) => {
                let pose = |triangle| prepared.pose_triangle(Portable, model, state.cache, triangle, &mut ());
                let nodes = state.refitted().wide(asset.wide_nodes(state.row), pose);
                self.enter(Tree::Refitted, nodes);
                false
            }
            _ => {
                let (actor, stack) = (self.actor(), &mut context.binary);
                pass_cluster::<ANY, C>(
                    actor,
                    (state, posed),
                    refitted,
                    self.start,
                    &mut self.traveller,
                    stack,
                    counters,
                )
            }
        }
    }

    /// Enters a cluster's tree in its local space, if the ray meets the box around it.
    #[inline(always)]
    fn enter_fuzzy(&mut self, asset: &'a Asset, state: &ClusterState, posed: &'a PosedCluster, local: &LocalFrame) {
        let model = asset.model();
        let row = &model.clusters[state.row as usize];
        let (origin, direction) = (self.traveller.origin, self.traveller.direction);
        let entered = local.enter(origin, direction, &posed.frame.bounds_world);
        let range = (self.start, self.traveller.limit);
        if entered.0.clip(&row.bounds_local, range).is_none() {
            return;
        }
        let [fuzzy, on_rest] = asset.lattice_rays(state.row, &entered);
        let ray = FuzzyRay {
            boxes: self.actor().prepared.fuzzy_boxes(model, state, posed),
            fuzzy,
            posed: on_rest,
        };
        self.fuzzy = Some((asset.wide_nodes(state.row), ray));
        self.tree = Tree::Fuzzy;
        self.floors[Tree::Fuzzy.depth()] = self.count;
        self.next = Next::MeetNode(0);
    }

    /// Traverses an instance at once; true when the search is over.
    #[inline(always)]
    pub(in crate::trace) fn pass_actor<const ANY: bool, S: Lanes, C: Count>(
        &mut self,
        simd: S,
        actor: Actor<'_>,
        whole: Option<&Whole>,
        stack: &mut WideStack,
        context: &mut ClusterContext,
        counters: &mut C,
    ) -> bool {
        let (nodes, ray) = self.world[0];
        let mut inside = Flight::in_scene(self.traveller.clone(), self.start, nodes, ray, 0);
        inside.enter_actor(actor, whole);
        while inside.step::<ANY, S, C>(simd, stack, context, counters) {}
        self.traveller = inside.traveller;
        ANY && self.traveller.best.is_some()
    }
}
