use super::bvh_primitive::{BoxLanes, around, half_area};
use super::bvh_split::Split;
use crate::simd::Lanes;

/// So many primitives, or fewer, are parted without bins, which would outnumber them.
pub(super) const FEW: usize = 8;

/// So many, or fewer, are parted as is best of all ways.
const VERY_FEW: usize = 4;

/// Parts `primitives` where the sum of both sides' half areas times their numbers is least, if it is below `limit`: of all
/// partitions where they are very few, else of those at centers.
#[inline(always)]
pub(super) fn split_few<S: Lanes>(simd: S, primitives: &mut [BoxLanes], scale: S::F4, limit: f32) -> Option<Split> {
    let (order, left) = if primitives.len() <= VERY_FEW {
        best_partition(simd, primitives, scale, limit)
    } else {
        best_center(simd, primitives, scale, limit)
    }?;
    let mut sorted = [BoxLanes::EMPTY; FEW];
    for (to, from) in sorted.iter_mut().zip(&order[..primitives.len()]) {
        *to = primitives[usize::from(*from)];
    }
    primitives.copy_from_slice(&sorted[..primitives.len()]);
    let (below, above) = primitives.split_at(left);
    Some(Split {
        left,
        bounds: [around(simd, below), around(simd, above)],
    })
}

/// The cheapest partition, as an order and how many of it go left.
#[inline(always)]
fn best_partition<S: Lanes>(simd: S, primitives: &[BoxLanes], scale: S::F4, limit: f32) -> Option<([u8; FEW], usize)> {
    const SUBSETS: usize = 1 << VERY_FEW;
    let subsets = 1usize << primitives.len();
    let mut unions = [simd.load8(&BoxLanes::EMPTY.0); SUBSETS];
    let mut costs = [0.0; SUBSETS];
    for subset in 1..subsets - 1 {
        let (own, others) = (subset.trailing_zeros() as usize, subset & (subset - 1));
        unions[subset] = simd.max8(unions[others], simd.load8(&primitives[own].0));
        costs[subset] = subset.count_ones() as f32 * half_area(simd, unions[subset], scale);
    }
    let (mut best, mut left) = (limit, 0);
    // The last primitive goes right.
    for subset in 1..subsets / 2 {
        let cost = costs[subset] + costs[subsets - 1 - subset];
        if cost < best {
            (best, left) = (cost, subset);
        }
    }
    let mut order = [0; FEW];
    let mut place = 0;
    for side in [left, subsets - 1 - left] {
        for i in 0..primitives.len() {
            order[place % FEW] = i as u8;
            place += side >> i & 1;
        }
    }
    (left != 0).then_some((order, left.count_ones() as usize))
}

/// The cheapest partition at a center along an axis, as an order and how many of it go left.
#[inline(always)]
fn best_center<S: Lanes>(simd: S, primitives: &[BoxLanes], scale: S::F4, limit: f32) -> Option<([u8; FEW], usize)> {
    let count = primitives.len();
    let mut keys = [[0.0; FEW]; 3];
    for (i, primitive) in primitives.iter().enumerate() {
        let center = simd.store4(primitive.half_center(simd));
        for axis in 0..3 {
            keys[axis][i] = center[axis];
        }
    }
    let empty = simd.load8(&BoxLanes::EMPTY.0);
    let (mut best, mut found) = (limit, None);
    for keys in &keys {
        let ranks = simd.ranks8(keys, count);
        let mut order = [0u8; FEW];
        for i in 0..count {
            order[usize::from(ranks[i]) % FEW] = i as u8;
        }
        let mut below = [0.0; FEW];
        let mut union = empty;
        for i in 1..count {
            union = simd.max8(union, simd.load8(&primitives[usize::from(order[i - 1])].0));
            below[i] = i as f32 * half_area(simd, union, scale);
        }
        let mut union = empty;
        for i in (1..count).rev() {
            union = simd.max8(union, simd.load8(&primitives[usize::from(order[i])].0));
            let cost = below[i] + (count - i) as f32 * half_area(simd, union, scale);
            if cost < best {
                best = cost;
                found = Some((order, i));
            }
        }
    }
    found
}
