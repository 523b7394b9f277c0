use super::{flight::Actor, lone_rays::LoneTree, traveller::Traveller};
use crate::{
    Aabb, InstanceId,
    cluster_frame::{BundleFrame, LatticeRay, LocalFrame},
    prepared::{ClusterState, PosedCluster},
    simd::Lanes,
    wide::{FuzzyBoxes, FuzzyNodes, FuzzyPath, FuzzyRay, PACKET},
};
use restpose_formats::rows::WideNodeRow;

/// A cluster's tree in its local space.
pub(super) struct FuzzyTree<'a> {
    actor: Actor<'a>,
    cluster: u32,
    /// The cache row that moves it, or `NONE`.
    cache: u32,
    nodes: &'a [WideNodeRow],
    boxes: FuzzyBoxes<'a>,
    local: &'a LocalFrame,
    bounds_world: &'a Aabb,
    /// By their places in the packet, on the lattices of the fuzzy boxes and of the rest positions, where `ready` has a bit.
    rays: &'a mut [[LatticeRay; 2]; PACKET],
    ready: u64,
}

impl<'a> FuzzyTree<'a> {
    /// `rays` is room for those that part.
    pub(super) fn new(
        actor: Actor<'a>,
        state: &ClusterState,
        posed: &'a PosedCluster,
        local: &'a LocalFrame,
        rays: &'a mut [[LatticeRay; 2]; PACKET],
    ) -> Self {
        let model = actor.asset.model();
        Self {
            actor,
            cluster: state.row,
            cache: state.cache,
            nodes: actor.asset.wide_nodes(state.row),
            boxes: actor.prepared.fuzzy_boxes(model, state, posed),
            local,
            bounds_world: &posed.frame.bounds_world,
            rays,
            ready: 0,
        }
    }

    /// Its nodes, for a bundle.
    pub(super) fn for_bundle<'p>(&self, frame: &BundleFrame, path: &'p mut FuzzyPath) -> FuzzyNodes<'p>
    where
        'a: 'p,
    {
        let lattices = self.actor.asset.local_lattices(self.cluster, frame);
        FuzzyNodes::new(self.nodes, self.boxes, lattices, path)
    }
}

impl<'a> LoneTree for FuzzyTree<'a> {
    type Node = WideNodeRow;
    type Ray = FuzzyRay<'a>;

    fn id(&self) -> InstanceId {
        self.actor.id
    }

    #[inline(always)]
    fn nodes(&self) -> &[WideNodeRow] {
        self.nodes
    }

    fn ray(&mut self, place: usize, traveller: &Traveller) -> FuzzyRay<'a> {
        let ray = &mut self.rays[place % PACKET];
        if self.ready >> (place % PACKET) & 1 == 0 {
            self.ready |= 1 << (place % PACKET);
            let entered = self
                .local
                .enter(traveller.origin, traveller.direction, self.bounds_world);
            *ray = self.actor.asset.lattice_rays(self.cluster, &entered);
        }
        let [fuzzy, posed] = *ray;
        FuzzyRay {
            boxes: self.boxes,
            fuzzy,
            posed,
        }
    }

    #[inline(always)]
    fn corners<S: Lanes>(&self, simd: S, triangle: u32) -> [[f32; 3]; 3] {
        let Actor { asset, prepared, .. } = self.actor;
        prepared.pose_triangle(simd, asset.model(), self.cache, triangle, &mut ())
    }
}
