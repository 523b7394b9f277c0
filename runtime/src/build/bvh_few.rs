use super::bvh_eight::{EightBoxes, cheapest, lowest};
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
pub(super) fn split_few<S: Lanes>(
    simd: S,
    primitives: &mut [BoxLanes],
    bounds: &BoxLanes,
    scale: S::F4,
    limit: f32,
) -> Option<Split> {
    if let [a, b] = primitives {
        let bounds = [*a, *b];
        let one = half_area(simd, simd.load8(&a.0), scale);
        let other = half_area(simd, simd.load8(&b.0), scale);
        return (one + other < limit).then_some(Split { left: 1, bounds });
    }
    let (order, left) = if primitives.len() <= VERY_FEW {
        best_partition(simd, primitives, scale, limit)
    } else {
        best_center(simd, primitives, scale, limit, bounds)
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

/// The cheapest partition of three or four, as an order and how many of it go left.
#[inline(always)]
fn best_partition<S: Lanes>(simd: S, primitives: &[BoxLanes], scale: S::F4, limit: f32) -> Option<([u8; FEW], usize)> {
    let last = primitives.len() - 1;
    let none = simd.load8(&BoxLanes::EMPTY.0);
    let a = simd.load8(&primitives[0].0);
    let b = simd.load8(&primitives[1].0);
    let c = if last == 3 { simd.load8(&primitives[2].0) } else { none };
    let z = simd.load8(&primitives[last].0);
    let (ab, ac, bc) = (simd.max8(a, b), simd.max8(a, c), simd.max8(b, c));
    let abc = simd.max8(ab, c);
    // A lane for each set without the last, which goes right.
    let left = [none, a, b, ab, c, ac, bc, abc];
    let mut right = [abc, bc, ac, c, ab, b, a, none];
    for side in &mut right {
        *side = simd.max8(*side, z);
    }
    let scale = simd.join(scale, scale);
    let left = EightBoxes::new(simd, left).half_areas(simd, scale);
    let right = EightBoxes::new(simd, right).half_areas(simd, scale);
    let members = simd.load8(&MEMBERS);
    let others = simd.sub8(simd.splat8(primitives.len() as f32), members);
    let cost = simd.add8(simd.mul8(left, members), simd.mul8(right, others));
    let cost = simd.max8(cost, simd.load8(&NO_SETS[last - 2]));
    let best = lowest(simd, cost);
    let set = match best < limit {
        true => simd.le8(cost, simd.splat8(best)).trailing_zeros() as usize,
        false => return None,
    };
    let (mut order, mut place) = ([0; FEW], 0);
    for side in [set, !set] {
        for i in 0..=last {
            order[place % FEW] = i as u8;
            place += side >> i & 1;
        }
    }
    Some((order, set.count_ones() as usize))
}

/// How many are in each set.
const MEMBERS: [f32; 8] = [0.0, 1.0, 1.0, 2.0, 1.0, 2.0, 2.0, 3.0];

/// Infinite in lanes whose sets are none, for three primitives and for four.
const NO_SETS: [[f32; 8]; 2] = {
    let (no, yes) = (f32::INFINITY, f32::NEG_INFINITY);
    [
        [no, yes, yes, yes, no, no, no, no],
        [no, yes, yes, yes, yes, yes, yes, yes],
    ]
};

/// The cheapest partition at a center along an axis, as an order and how many of it go left.
#[inline(always)]
fn best_center<S: Lanes>(
    simd: S,
    primitives: &[BoxLanes],
    scale: S::F4,
    limit: f32,
    bounds: &BoxLanes,
) -> Option<([u8; FEW], usize)> {
    let last = primitives.len() - 1;
    let mut own = [BoxLanes::EMPTY; FEW];
    for i in 0..FEW {
        own[i] = primitives[i.min(last)];
    }
    let counted = simd.load8(&COUNTED[last]);
    let boxes = EightBoxes::load(simd, &own).only(simd, counted);
    let scale = simd.join(scale, scale);
    // Centers fall along the order, so "below" has the greater ones.
    let below = simd.load8(&NUMBERS);
    let above = simd.max8(simd.sub8(simd.splat8(primitives.len() as f32), below), simd.splat8(0.0));
    let mut orders = [[0.0; FEW]; 3];
    let mut costs = [below; 3];
    for axis in 0..3 {
        // Seen from the node's side, so that the lowest bits do not matter.
        let low = simd.splat8(-0.5 * bounds.0[axis]);
        let keys = simd.min8(simd.sub8(boxes.half_centers(simd, axis), low), counted);
        let order = simd.order8(keys);
        costs[axis] = boxes.permuted(simd, order).border_costs(simd, below, above, scale);
        simd.store8(order, &mut orders[axis]);
    }
    let (_, axis, left) = cheapest(simd, &costs, limit)?;
    let mut order = [0; FEW];
    for (to, from) in order.iter_mut().zip(&orders[axis]) {
        *to = from.to_bits() as u8;
    }
    Some((order, left))
}

const NUMBERS: [f32; FEW] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// By how many but one there are: infinity for those, minus infinity for the others.
const COUNTED: [[f32; FEW]; FEW] = {
    let mut all = [[f32::NEG_INFINITY; FEW]; FEW];
    let mut last = 0;
    while last < FEW {
        let mut lane = 0;
        while lane <= last {
            all[last][lane] = f32::INFINITY;
            lane += 1;
        }
        last += 1;
    }
    all
};
