use super::{lone_rays::LoneTree, traveller::Traveller};
use crate::{
    Aabb, InstanceId,
    cluster_frame::SlabRay,
    posed_mesh::PosedMesh,
    simd::Lanes,
    wide::{PACKET, WideNode, WideRay},
};

/// The tree over all triangles of an instance.
pub(super) struct WholeTree<'a> {
    id: InstanceId,
    mesh: PosedMesh<'a>,
    bounds: Aabb,
    /// By their places in the packet, ready for this tree where `ready` has a bit.
    rays: &'a mut [WideRay; PACKET],
    ready: u64,
}

impl<'a> WholeTree<'a> {
    /// `rays` is room for those that part.
    pub(super) fn new(id: InstanceId, mesh: PosedMesh<'a>, rays: &'a mut [WideRay; PACKET]) -> Self {
        Self {
            id,
            mesh,
            bounds: mesh.nodes[0].around(),
            rays,
            ready: 0,
        }
    }
}

impl LoneTree for WholeTree<'_> {
    type Node = WideNode;
    type Ray = WideRay;

    fn id(&self) -> InstanceId {
        self.id
    }

    #[inline(always)]
    fn nodes(&self) -> &[WideNode] {
        self.mesh.nodes
    }

    #[inline(always)]
    fn ray(&mut self, place: usize, traveller: &Traveller) -> WideRay {
        let ray = &mut self.rays[place % PACKET];
        if self.ready >> (place % PACKET) & 1 == 0 {
            self.ready |= 1 << (place % PACKET);
            *ray = WideRay::new(&SlabRay::in_world(traveller.origin, traveller.direction, &self.bounds));
        }
        *ray
    }

    #[inline(always)]
    fn corners<S: Lanes>(&self, _simd: S, triangle: u32) -> [[f32; 3]; 3] {
        self.mesh.corners(triangle)
    }
}
