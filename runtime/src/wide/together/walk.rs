use super::{
    bundled::{Bundled, Together},
    ray_group::GROUP,
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb,
    simd::{Lanes, Portable, SimdLevel, prefetch},
    wide::{WideBoxes, WideNode, WideStack},
};
use restpose_formats::rows::WideChild;

/// Children that a bundle looks at before it asks at each node which of its rays go there: bundles as narrow as the triangles
/// seldom look at more. 8 and 16 were up to a tenth slower with 1M rays of a camera, on a fox of 9k and 147k triangles and on ELEPHANT, and
/// no better with 10,000 to 100,000; 64 took a fifth longer where rays have to part.
const PATIENCE: u32 = 32;

/// Rays that are so few at a node that each goes on alone, where it is asked which they are. One and two were slower with few
/// rays, eight no faster.
const FEW: u32 = 4;

/// What rays of a bundle have come to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// A leaf that these groups may touch.
    Leaf { leaf: u32, groups: u32 },
    /// A node below which few rays go on: their places, as bits.
    Alone { node: u32, places: u64 },
}

/// A tree as a bundle goes down it.
pub(crate) trait BundleTree {
    /// Makes a node ready: a child of the one that is ready at `above`, or the root. The place where it is ready from then on, as
    /// long as nodes below it are entered only.
    fn enter<S: Lanes>(&mut self, simd: S, child: u32, above: Option<u32>) -> u32;
    fn node(&self, at: u32) -> &WideNode;
    /// Asks for what [`Self::enter`] reads.
    fn prefetch(&self, child: u32);
}

/// A tree in world space, whose nodes are ready where they are.
impl BundleTree for &[WideNode] {
    #[inline(always)]
    fn enter<S: Lanes>(&mut self, _simd: S, child: u32, _above: Option<u32>) -> u32 {
        child
    }

    #[inline(always)]
    fn node(&self, at: u32) -> &WideNode {
        &self[at as usize]
    }

    #[inline(always)]
    fn prefetch(&self, child: u32) {
        prefetch(std::slice::from_ref(&self[child as usize]));
    }
}

/// As [`Descent`](crate::wide::Descent), for the rays of a bundle: each child is looked at by those groups of rays whose own bundle meets
/// its box, and goes to `visit` where it is a leaf or few rays are left. What `visit` cuts counts from then on.
///
/// Every leaf that a ray may touch is visited with the ray's group, or lies below a node at which the ray goes on alone.
pub(crate) fn walk_together(
    level: SimdLevel,
    tree: &mut impl BundleTree,
    together: &Together,
    bundled: &mut Bundled,
    stack: &mut WideStack,
    visit: &mut impl FnMut(Part, &mut Bundled) -> bool,
) -> bool {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(
            simd: Avx2,
            tree: &mut impl BundleTree,
            together: &Together,
            bundled: &mut Bundled,
            stack: &mut WideStack,
            visit: &mut impl FnMut(Part, &mut Bundled) -> bool,
        ) -> bool {
            walk_with(simd, tree, together, bundled, stack, visit)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, tree, together, bundled, stack, visit) };
    }
    walk_with(Portable, tree, together, bundled, stack, visit)
}

#[inline(always)]
fn walk_with<S: Lanes>(
    simd: S,
    tree: &mut impl BundleTree,
    together: &Together,
    bundled: &mut Bundled,
    stack: &mut WideStack,
    visit: &mut impl FnMut(Part, &mut Bundled) -> bool,
) -> bool {
    let mut node = tree.enter(simd, 0, None);
    let mut count = 0;
    let mut looked = 0;
    let mut bundle = together.all;
    let mut limit = bundled.limit;
    loop {
        let parent = tree.node(node);
        let [enter, exit] = parent.meet(simd, node, &bundle, bundle.start, limit);
        // Not the children: where their boxes are, too, must be known.
        let places = std::array::from_fn(|place| node << 3 | place as u32);
        let first = count;
        count += simd.sort8(enter, exit, &places, stack.eight(count));
        // Bundles go to most of these, and the rays that part from them, too: 5 % of a picture before 1.35 million triangles. To
        // ask for leaves' triangles as well was no faster.
        for pending in first..count {
            let (_, place) = stack.at(pending);
            let child = parent.children[place as usize % 8];
            if child & WideChild::LEAF_BIT == 0 {
                tree.prefetch(child);
            }
        }
        loop {
            if count == 0 {
                return false;
            }
            count -= 1;
            let (enter, place) = stack.at(count);
            let (at, place) = (place >> 3, place as usize % 8);
            let parent = tree.node(at);
            let child = parent.children[place];
            if enter > bundled.limit || child == WideChild::EMPTY {
                continue;
            }
            looked += 1;
            let limits = &bundled.packet.limits;
            let mut groups = together.groups.meeting(simd, parent, place, limits) & together.going;
            if groups == 0 {
                continue;
            }
            if child & WideChild::LEAF_BIT != 0 {
                let leaf = child & !WideChild::LEAF_BIT;
                if visit(Part::Leaf { leaf, groups }, bundled) {
                    return true;
                }
                continue;
            }
            if looked > PATIENCE || groups.is_power_of_two() {
                let places =
                    bundled.meeting_with(simd, groups, together.rays, &box_of(parent, place), together.outwards);
                if places.count_ones() <= FEW {
                    if places != 0 && visit(Part::Alone { node: child, places }, bundled) {
                        return true;
                    }
                    continue;
                }
                groups = groups_of(places);
            }
            node = tree.enter(simd, child, Some(at));
            (bundle, limit) = if groups.is_power_of_two() {
                let group = groups.trailing_zeros() as usize % GROUP;
                (together.groups.one(group), bundled.packet.limits[group])
            } else {
                (together.all, bundled.limit)
            };
            break;
        }
    }
}

/// The groups of some places.
#[inline(always)]
fn groups_of(places: u64) -> u32 {
    // A byte is a group: its lowest bit says whether any of its bits is set.
    let pairs = places | places >> 4;
    let pairs = pairs | pairs >> 2;
    let any = (pairs | pairs >> 1) & 0x0101_0101_0101_0101;
    (any.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32
}

#[inline(always)]
fn box_of(node: &WideNode, place: usize) -> Aabb {
    let place = place % 8;
    let corner = |planes: &[[f32; 8]; 3]| [planes[0][place], planes[1][place], planes[2][place]];
    Aabb {
        min: corner(&node.planes[0]),
        max: corner(&node.planes[1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_in_their_groups() {
        let mut random = fastrand::Rng::with_seed(35);
        for _ in 0..10_000 {
            let places = (0..random.usize(..6)).fold(0u64, |places, _| places | 1 << random.u32(..64));
            let expected = (0..64).filter(|place| places >> place & 1 == 1);
            let expected = expected.fold(0, |groups, place| groups | 1 << (place / GROUP));
            assert_eq!(groups_of(places), expected, "{places:x}");
        }
        assert_eq!((groups_of(0), groups_of(u64::MAX)), (0, 0xff));
    }
}
