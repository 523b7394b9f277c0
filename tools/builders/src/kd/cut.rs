use super::bins::{Bins, Border};
use super::cell_cost::CellCost;
use super::fragment::{Fragment, Plane};
use restpose_formats::geom::Aabb;

/// How a node is cut in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cut {
    /// Everything lies above the position: the left child is empty.
    EmptyBelow { axis: usize, position: f32 },
    /// Everything lies below the position: the right child is empty.
    EmptyAbove { axis: usize, position: f32 },
    /// The children get at most `left` and `right` fragments.
    Part { plane: Plane, left: usize, right: usize },
}

impl Cut {
    /// Most fragments that both children of a node with `count` get together.
    pub(super) fn references(&self, count: usize) -> usize {
        match self {
            Self::EmptyBelow { .. } | Self::EmptyAbove { .. } => count,
            Self::Part { left, right, .. } => left + right,
        }
    }
}

/// A cut and C_Part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PricedCut {
    pub cost: f32,
    pub cut: Cut,
}

/// The cheapest cut that takes off empty space, if one costs less than `limit`: there are six, at the sides of `bounds`,
/// the box around the node's `total` fragments.
pub(super) fn cheapest_gap(
    cell: &Aabb,
    bounds: &Aabb,
    cost: &CellCost,
    total: usize,
    mut limit: f32,
) -> Option<PricedCut> {
    let mut best = None;
    let total = total as f32;
    for axis in 0..3 {
        let position = bounds.min[axis];
        if position > cell.min[axis] {
            let price = cost.cut(axis, cost.share(axis, position), 0.0, total);
            if price < limit {
                limit = price;
                let cut = Cut::EmptyBelow { axis, position };
                best = Some(PricedCut { cost: price, cut });
            }
        }
        let position = bounds.max[axis];
        if position < cell.max[axis] {
            let price = cost.cut(axis, cost.share(axis, position), total, 0.0);
            if price < limit {
                limit = price;
                let cut = Cut::EmptyAbove { axis, position };
                best = Some(PricedCut { cost: price, cut });
            }
        }
    }
    best
}

/// The cut at the better of the two sides of fragments next to `near`, if it costs less than `limit`.
///
/// Between two neighbouring sides the counts do not change and the cost is linear (§4.1.2), so the cheaper end of the
/// piece around `near` is no dearer than `near` itself.
pub(super) fn cut_beside(
    fragments: &[Fragment],
    bounds: &Aabb,
    cost: &CellCost,
    axis: usize,
    near: f32,
    limit: f32,
) -> Option<PricedCut> {
    let beside = match axis {
        0 => sides_beside::<0>(fragments, near),
        1 => sides_beside::<1>(fragments, near),
        _ => sides_beside::<2>(fragments, near),
    };
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    // A plane on the bounds parts nothing but what lies in it.
    let usable = |position: f32| {
        min < position && position < max
            || fragments
                .iter()
                .any(|f| f.min[axis] == position && f.max[axis] == position)
    };
    let (first, second) = if beside.left > beside.right {
        (beside.below, beside.above)
    } else {
        (beside.above, beside.below)
    };
    let position = if min <= first && first <= max && usable(first) {
        first
    } else if min <= second && second <= max && usable(second) {
        second
    } else {
        return None;
    };
    let t = cost.share(axis, position);
    let price = cost.cut(axis, t, beside.left as f32, beside.right as f32);
    (price < limit).then_some(PricedCut {
        cost: price,
        cut: Cut::Part {
            plane: Plane {
                axis,
                position,
                planar_left: t <= 0.5,
            },
            left: beside.left as usize,
            right: beside.right as usize,
        },
    })
}

/// What lies around a position along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Beside {
    /// The nearest side of a fragment below the position; −∞ if there is none.
    below: f32,
    /// The nearest side at or above it; ∞ if there is none.
    above: f32,
    /// Fragments that begin below it.
    left: u32,
    /// Fragments that end at or above it.
    right: u32,
}

fn sides_beside<const AXIS: usize>(fragments: &[Fragment], near: f32) -> Beside {
    let mut beside = Beside {
        below: f32::NEG_INFINITY,
        above: f32::INFINITY,
        left: 0,
        right: 0,
    };
    for fragment in fragments {
        let (min, max) = (fragment.min[AXIS], fragment.max[AXIS]);
        beside.left += u32::from(min < near);
        beside.right += u32::from(max >= near);
        for side in [min, max] {
            let low = if side < near { side } else { f32::NEG_INFINITY };
            let high = if side < near { f32::INFINITY } else { side };
            beside.below = if low > beside.below { low } else { beside.below };
            beside.above = if high < beside.above { high } else { beside.above };
        }
    }
    beside
}

/// The cheapest cut at a border of the bins or at the sides of `bounds`, if one costs less than a leaf.
///
/// The bins must have been filled with the fragments, and `bounds` be the box around these. With `beside`, a cut at a
/// border is moved to the nearest side of a fragment that makes it no dearer.
pub(super) fn cheapest_cut(
    fragments: &[Fragment],
    cell: &Aabb,
    bounds: &Aabb,
    bins: &Bins,
    cost: &CellCost,
    beside: bool,
) -> Option<PricedCut> {
    let total = fragments.len();
    let leaf = cost.leaf(total);
    let gap = cheapest_gap(cell, bounds, cost, total, leaf);
    let limit = gap.map_or(leaf, |gap| gap.cost);
    let border = bins.cheapest_border(cost, total).filter(|border| border.cost < limit);
    let part = border.and_then(|border| {
        let at = if beside {
            None
        } else {
            cut_at(bins, border, bounds, cost)
        };
        at.or_else(|| {
            let near = bins.near(border.axis, border.below);
            cut_beside(fragments, bounds, cost, border.axis, near, limit)
        })
    });
    part.or(gap)
}

/// The cut at the very border, if that lies within the fragments; one beside them would part nothing.
pub(super) fn cut_at(bins: &Bins, border: Border, bounds: &Aabb, cost: &CellCost) -> Option<PricedCut> {
    let Border {
        axis,
        left,
        right,
        cost: price,
        ..
    } = border;
    let position = bins.position(axis, border.below);
    (bounds.min[axis] < position && position < bounds.max[axis]).then(|| PricedCut {
        cost: price,
        cut: Cut::Part {
            plane: Plane {
                axis,
                position,
                planar_left: cost.share(axis, position) <= 0.5,
            },
            left,
            right,
        },
    })
}
