use super::bvh::{BvhNode, BvhSettings, MAX_BVH_DEPTH};
use super::bvh_bins::{BinCount, Bins};
use super::bvh_extent::Extent;
use super::bvh_primitive::BoxLanes;
use super::bvh_split::{Split, halve, split};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::simd::{Lanes, Portable, SimdLevel};

/// What holds for all nodes of a build.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub level: SimdLevel,
    pub count: BinCount,
    pub settings: BvhSettings,
}

/// A node that is still to be made, and the part of the lists that it owns.
#[derive(Debug)]
pub(super) struct Job<'a> {
    pub primitives: &'a mut [BoxLanes],
    pub references: &'a mut [u32],
    /// Place of `references` among all.
    pub first: u32,
    pub node: &'a mut BvhNode,
    /// Room for all that can stand below: two nodes per primitive but one.
    pub below: &'a mut [BvhNode],
    /// Place of `below` among all.
    pub below_first: u32,
    pub depth: usize,
    pub extent: Extent,
}

/// Parts one node; `None` when it becomes a leaf.
pub(super) fn split_one(plan: &Plan, job: &mut Job<'_>, bins: &mut Bins) -> Option<Split> {
    #[inline(always)]
    fn body<S: Lanes>(simd: S, plan: &Plan, job: &mut Job<'_>, bins: &mut Bins) -> Option<Split> {
        split_at_depth(simd, plan, job.primitives, &job.extent.bounds, job.depth, bins)
    }
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (plan.level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, plan: &Plan, job: &mut Job<'_>, bins: &mut Bins) -> Option<Split> {
            body(simd, plan, job, bins)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, plan, job, bins) };
    }
    body(Portable, plan, job, bins)
}

/// Builds the tree of a job, without gaps; how much of the room below was used.
pub(super) fn build_subtree(plan: &Plan, job: Job<'_>, bins: &mut Bins) -> usize {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (plan.level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, plan: &Plan, job: Job<'_>, bins: &mut Bins) -> usize {
            build_with(simd, plan, job, bins)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, plan, job, bins) };
    }
    build_with(Portable, plan, job, bins)
}

/// A node of a subtree that is still to be made.
#[derive(Clone, Copy)]
struct Open {
    /// Place below the job's node.
    place: usize,
    begin: usize,
    end: usize,
    depth: usize,
    bounds: BoxLanes,
}

impl Open {
    const NONE: Self = Self {
        place: 0,
        begin: 0,
        end: 0,
        depth: 0,
        bounds: BoxLanes::EMPTY,
    };
}

#[inline(always)]
fn build_with<S: Lanes>(simd: S, plan: &Plan, job: Job<'_>, bins: &mut Bins) -> usize {
    let Job {
        primitives,
        references,
        first,
        node,
        below,
        below_first,
        depth,
        extent,
    } = job;
    let mut used = 0;
    let mut open = [Open::NONE; MAX_BVH_DEPTH + 1];
    let mut count = 0;
    let mut next = Open {
        place: usize::MAX,
        begin: 0,
        end: primitives.len(),
        depth,
        bounds: extent.bounds,
    };
    loop {
        let own = &mut primitives[next.begin..next.end];
        let split = split_at_depth(simd, plan, own, &next.bounds, next.depth, bins);
        let made = match split {
            None => {
                for (reference, primitive) in references[next.begin..next.end].iter_mut().zip(own.iter()) {
                    *reference = primitive.id();
                }
                BvhNode::leaf(next.bounds.aabb(), first + next.begin as u32, own.len() as u32)
            }
            Some(_) => BvhNode::inner(next.bounds.aabb(), below_first + used as u32),
        };
        match below.get_mut(next.place) {
            Some(place) => *place = made,
            None => *node = made,
        }
        if let Some(Split { left, bounds }) = split {
            let child = |place, begin, end, bounds| Open {
                place,
                begin,
                end,
                depth: next.depth + 1,
                bounds,
            };
            let middle = next.begin + left;
            // The depth is kept, so there is room.
            open[count] = child(used + 1, middle, next.end, bounds[1]);
            count += 1;
            next = child(used, next.begin, middle, bounds[0]);
            used += 2;
        } else if count == 0 {
            return used;
        } else {
            count -= 1;
            next = open[count];
        }
    }
}

/// Parts the primitives of a node; `None` when it becomes a leaf.
///
/// Where halving from here on only just keeps [`MAX_BVH_DEPTH`], the node is halved: centers that are spaced
/// exponentially would make a tree as deep as they are many.
#[inline(always)]
fn split_at_depth<S: Lanes>(
    simd: S,
    plan: &Plan,
    primitives: &mut [BoxLanes],
    bounds: &BoxLanes,
    depth: usize,
    bins: &mut Bins,
) -> Option<Split> {
    if primitives.len() == 1 {
        return None;
    }
    let halvings = (primitives.len() - 1).ilog2() as usize + 1;
    if depth + halvings < MAX_BVH_DEPTH {
        split(simd, primitives, bounds, plan.count, &plan.settings, bins)
    } else {
        Some(halve(simd, primitives, bounds))
    }
}
