use super::both::both;
use super::bvh::{BvhNode, MAX_BVH_DEPTH};
use super::bvh_bins::{BinMap, Bins};
use super::bvh_extent::Extent;
use super::bvh_primitive::{BoxLanes, half_area};
use super::bvh_split::unit_scale;
use super::bvh_subtree::{Job, Plan, build_subtree, split_one};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::simd::{Lanes, Portable, SimdLevel};

/// Nodes with more primitives are parted one by one, each side a job of its own.
///
/// To part nodes of more than 65,536 on all threads, in chunks whose bins are merged and whose misplaced ranges trade places, took
/// 20 % longer on one thread (1M boxes), and no less on two; what it gains on many was not measured.
pub(super) const LARGE: usize = 4096;

/// So many primitives of a large node say what all would, if it is even.
///
/// Of 1M boxes of a surface, 512, 1024, 2048 and 4096 make trees that cost 0.7, 0.4, 0.3 and 0 % more than all do, and take 18,
/// 17, 15 and 10 % less time (ELEPHANT: 1.2, 1.2, 0.4 and 0 % more). Where few are long, a sample with all of these was tried:
/// it cost up to 6 % more in an uneven room, and saved 5 % of the time.
const SAMPLE: usize = 2048;

/// Builds the tree of a job, without gaps; how much of the room below was used.
pub(super) fn build_large(plan: &Plan, mut job: Job<'_>, bins: &mut Bins) -> usize {
    if job.primitives.len() <= LARGE {
        return build_subtree(plan, job, bins);
    }
    let Some(LargeSplit { left, sides }) = split_large(plan, &mut job, bins) else {
        return 0;
    };
    let (primitives, references) = (job.primitives.split_at_mut(left), job.references.split_at_mut(left));
    let (nodes, below) = job.below.split_at_mut(2);
    let [left_node, right_node] = nodes else { return 0 };
    let left_used = build_large(
        plan,
        Job {
            primitives: primitives.0,
            references: references.0,
            first: job.first,
            node: left_node,
            below: &mut *below,
            below_first: job.below_first + 2,
            depth: job.depth + 1,
            extent: sides[0],
        },
        bins,
    );
    let right_used = build_large(
        plan,
        Job {
            primitives: primitives.1,
            references: references.1,
            first: job.first + left as u32,
            node: right_node,
            below: &mut below[left_used..],
            below_first: job.below_first + 2 + left_used as u32,
            depth: job.depth + 1,
            extent: sides[1],
        },
        bins,
    );
    2 + left_used + right_used
}

/// Where a large node was parted.
#[derive(Clone, Copy, Debug)]
pub(super) struct LargeSplit {
    /// Primitives of the left child, which stand first.
    pub left: usize,
    /// What both children hold.
    pub sides: [Extent; 2],
}

/// Parts a large node and writes it; `None` when it became a leaf.
pub(super) fn split_large(plan: &Plan, job: &mut Job<'_>, bins: &mut Bins) -> Option<LargeSplit> {
    let halvings = (job.primitives.len() - 1).ilog2() as usize + 1;
    let deep = job.depth + halvings >= MAX_BVH_DEPTH;
    let sampled = match !deep && job.extent.is_even() {
        true => part_by_sample(plan, job.primitives, &job.extent.bounds, bins),
        false => None,
    };
    let Some(left) = sampled.or_else(|| split_one(plan, job, bins).map(|split| split.left)) else {
        let count = job.primitives.len() as u32;
        *job.node = BvhNode::leaf(job.extent.bounds.aabb(), job.first, count);
        for (reference, primitive) in job.references.iter_mut().zip(job.primitives.iter()) {
            *reference = primitive.id();
        }
        return None;
    };
    *job.node = BvhNode::inner(job.extent.bounds.aabb(), job.below_first);
    let (below, above) = job.primitives.split_at(left);
    let sides = both(true, || Extent::of(plan.level, below), || Extent::of(plan.level, above));
    Some(LargeSplit {
        left,
        sides: sides.into(),
    })
}

/// Parts primitives, more than [`SAMPLE`], by the border that is best for a sample of them; how many stand below, `None` where
/// the sample has no border that is better than a leaf.
fn part_by_sample(plan: &Plan, primitives: &mut [BoxLanes], bounds: &BoxLanes, bins: &mut Bins) -> Option<usize> {
    #[inline(always)]
    fn body<S: Lanes>(
        simd: S,
        plan: &Plan,
        primitives: &mut [BoxLanes],
        bounds: &BoxLanes,
        bins: &mut Bins,
    ) -> Option<usize> {
        let scale = simd.splat4(unit_scale(simd, bounds)?);
        let mut sample = std::mem::take(&mut bins.sample);
        sample.resize(SAMPLE, BoxLanes::EMPTY);
        write_sample(primitives, &mut sample);
        let count = plan.count.of(primitives.len());
        let map = BinMap::new(simd, &sample, count);
        bins.fill(simd, &sample, &map);
        bins.sample = sample;
        // That of `split`, for the number of the sample.
        let share = SAMPLE as f64 / primitives.len() as f64;
        let saved = share * plan.settings.traversal_cost / plan.settings.intersection_cost;
        let limit = (SAMPLE as f32 - saved as f32) * half_area(simd, simd.load8(&bounds.0), scale);
        let border = bins.best_border(simd, count, scale, limit)?;
        Some(map.part(simd, primitives, border))
    }
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (plan.level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(
            simd: Avx2,
            plan: &Plan,
            primitives: &mut [BoxLanes],
            bounds: &BoxLanes,
            bins: &mut Bins,
        ) -> Option<usize> {
            body(simd, plan, primitives, bounds, bins)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, plan, primitives, bounds, bins) };
    }
    body(Portable, plan, primitives, bounds, bins)
}

/// Writes one of each of as many stretches of the list as there is room for, which are as long as each other but for one; which
/// one differs, as lists of meshes repeat themselves.
fn write_sample(primitives: &[BoxLanes], sample: &mut [BoxLanes]) {
    let (all, count) = (primitives.len() as u64, sample.len() as u64);
    // A linear congruential generator, with the constants of Press et al., *Numerical Recipes*.
    let mut random = 0u32;
    for (number, to) in (0u64..).zip(sample) {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let (begin, end) = (number * all / count, (number + 1) * all / count);
        let within = (u64::from(random) * (end - begin)) >> 32;
        *to = primitives[(begin + within) as usize];
    }
}
