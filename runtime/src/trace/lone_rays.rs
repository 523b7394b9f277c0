use super::traveller::Traveller;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    InstanceId,
    simd::{Lanes, Portable, SimdLevel},
    wide::{Descent, WideBoxes, WideStack},
};
use restpose_formats::rows::WideChild;

/// A tree of an instance's, for rays of a packet that part from their bundle at one of its nodes.
///
/// They go one after the other, not in flight with each other ([`fly`](super::fly::fly)): there is little below the node, and what
/// one has fetched the next one finds. In flight, 1M rays of a camera before 1.35 million triangles
/// took a quarter longer.
pub(super) trait LoneTree {
    type Node: WideBoxes<Self::Ray>;
    type Ray;

    fn id(&self) -> InstanceId;
    fn nodes(&self) -> &[Self::Node];
    /// The ray at a place in the packet, ready for the tree.
    fn ray(&mut self, place: usize, traveller: &Traveller) -> Self::Ray;
    fn corners<S: Lanes>(&self, simd: S, triangle: u32) -> [[f32; 3]; 3];
}

/// Traverses the tree below a node, whose own box is not tested, with the ray at a place, which begins at the scaled `t`
/// `start`: to the closest hit, or to any if `ANY`.
pub(super) fn pass_below<const ANY: bool, T: LoneTree>(
    tree: &mut T,
    level: SimdLevel,
    node: u32,
    (place, traveller, start): (usize, &mut Traveller, f32),
    stack: &mut WideStack,
) {
    let ray = tree.ray(place, traveller);
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled<const ANY: bool, T: LoneTree>(
            simd: Avx2,
            tree: &T,
            node: u32,
            ray: &T::Ray,
            start: f32,
            traveller: &mut Traveller,
            stack: &mut WideStack,
        ) {
            pass_with::<ANY, _, T>(simd, tree, node, ray, start, traveller, stack);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled::<ANY, T>(simd, tree, node, &ray, start, traveller, stack) };
    }
    pass_with::<ANY, _, T>(Portable, tree, node, &ray, start, traveller, stack);
}

#[inline(always)]
fn pass_with<const ANY: bool, S: Lanes, T: LoneTree>(
    simd: S,
    tree: &T,
    node: u32,
    ray: &T::Ray,
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
        let Some(leaf) = way.next(simd, tree.nodes(), ray, below.take(), stack, &mut count, &mut ()) else {
            return;
        };
        let triangle = leaf & !WideChild::LEAF_BIT;
        if traveller.test(&tree.corners(simd, triangle), tree.id(), triangle) && ANY {
            return;
        }
    }
}
