use super::{lone_rays::LoneTree, traveller::Traveller};
use crate::{
    Aabb, InstanceId,
    cluster_frame::SlabRay,
    prepared::Whole,
    simd::Lanes,
    wide::{PACKET, WideNode, WideRay},
};
use restpose_formats::rows::TriangleRow;

/// The tree over all posed triangles of an instance.
pub(super) struct WholeTree<'a> {
    id: InstanceId,
    whole: &'a Whole,
    triangles: &'a [TriangleRow],
    bounds: Aabb,
    /// By their places in the packet, ready for this tree where `ready` has a bit.
    rays: &'a mut [WideRay; PACKET],
    ready: u64,
}

impl<'a> WholeTree<'a> {
    /// The whole's tree is not empty; `rays` is room for those that part.
    pub(super) fn new(
        id: InstanceId,
        whole: &'a Whole,
        triangles: &'a [TriangleRow],
        rays: &'a mut [WideRay; PACKET],
    ) -> Self {
        Self {
            id,
            whole,
            triangles,
            bounds: whole.nodes[0].around(),
            rays,
            ready: 0,
        }
    }

    #[inline(always)]
    pub(super) fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        let [a, b, c] = self.triangles[triangle as usize].corners;
        let positions = &self.whole.positions;
        [positions[a as usize], positions[b as usize], positions[c as usize]]
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
        &self.whole.nodes
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
        self.corners(triangle)
    }
}
