use super::traveller::Traveller;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, InstanceId,
    cluster_frame::SlabRay,
    prepared::Whole,
    simd::{Lanes, Portable, SimdLevel},
    wide::{Descent, PACKET, WideRay, WideStack},
};
use restpose_formats::rows::{TriangleRow, WideChild};

/// The tree over all posed triangles of an instance, for rays of a packet that part from their bundle at one of its nodes.
///
/// They go one after the other, not in flight with each other ([`fly`](super::fly::fly)): there is little below the node, and what
/// one has fetched the next one finds. In flight, 1M rays of a camera before 1.35 million triangles
/// took a quarter longer.
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

    /// Traverses the tree below a node, whose own box is not tested, with the ray at a place, which begins at the scaled `t`
    /// `start`: to the closest hit, or to any if `ANY`.
    pub(super) fn pass<const ANY: bool>(
        &mut self,
        level: SimdLevel,
        node: u32,
        (place, traveller, start): (usize, &mut Traveller, f32),
        stack: &mut WideStack,
    ) {
        let place = place % PACKET;
        if self.ready >> place & 1 == 0 {
            self.ready |= 1 << place;
            self.rays[place] = WideRay::new(&SlabRay::in_world(traveller.origin, traveller.direction, &self.bounds));
        }
        let ray = &self.rays[place];
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled<const ANY: bool>(
                simd: Avx2,
                tree: &WholeTree,
                node: u32,
                ray: &WideRay,
                start: f32,
                traveller: &mut Traveller,
                stack: &mut WideStack,
            ) {
                tree.pass_with::<ANY, _>(simd, node, ray, start, traveller, stack);
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled::<ANY>(simd, self, node, ray, start, traveller, stack) };
        }
        self.pass_with::<ANY, _>(Portable, node, ray, start, traveller, stack);
    }

    #[inline(always)]
    fn pass_with<const ANY: bool, S: Lanes>(
        &self,
        simd: S,
        node: u32,
        ray: &WideRay,
        start: f32,
        traveller: &mut Traveller,
        stack: &mut WideStack,
    ) {
        let (mut count, mut below) = (0, Some(node));
        loop {
            let way = Descent {
                start,
                limit: traveller.limit,
                floor: 0,
                is_far: false,
            };
            let nodes = &self.whole.nodes[..];
            let Some(leaf) = way.next(simd, nodes, ray, below.take(), stack, &mut count, &mut ()) else {
                return;
            };
            let triangle = leaf & !WideChild::LEAF_BIT;
            if traveller.test(&self.corners(triangle), self.id, triangle) && ANY {
                return;
            }
        }
    }
}
