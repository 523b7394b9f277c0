use super::kd_event::Event;
use super::sah::{CutCost, CutMeasure, KdSettings};
use restpose_formats::geom::Aabb;
use std::ops::Range;

/// The events of a node along one axis, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EventRange {
    /// First event in the axis's list.
    pub begin: usize,
    /// One past the last event.
    pub end: usize,
    /// How many of them begin a box. The node's other boxes begin on or before the cell's lower side.
    pub begun: u32,
}

/// The cheapest plane of a node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Split {
    pub cost: f64,
    pub axis: usize,
    pub position: f32,
    /// Boxes that lie in the plane go left, else right.
    pub planar_left: bool,
    /// Boxes of the left child.
    pub left: u32,
    /// Boxes of the right child.
    pub right: u32,
    /// The events at the plane, counted from the node's first along the axis.
    pub group: Range<usize>,
    /// How many events before the group begin a box, and how many up to its end.
    pub begun: [u32; 2],
}

/// The cheapest split of `cell` by Eq. 4.3, if one is cheaper than a leaf.
///
/// Candidates are all positions of events: planes inside the cell, and planes on its border that split off a flat cell
/// with the boxes that lie in it. Of equal costs the lowest axis wins, then the lowest position, then planar boxes left.
///
/// `lists` and `ranges` are per axis; `count` boxes are in the node.
pub(super) fn cheapest_split(
    lists: &[Vec<Event>; 3],
    ranges: &[EventRange; 3],
    cell: &Aabb,
    count: u32,
    settings: &KdSettings,
) -> Option<Split> {
    let mut limit = settings.intersection_cost * f64::from(count);
    let mut best = None;
    for axis in 0..3 {
        let Some(measure) = CutMeasure::new(cell, axis) else {
            continue;
        };
        let sweep = Sweep {
            cost: CutCost::new(measure, settings),
            axis,
            sides: (cell.min[axis], cell.max[axis]),
        };
        let EventRange { begin, end, begun } = ranges[axis];
        if let Some(split) = sweep.run(&lists[axis][begin..end], begun, count, limit) {
            limit = split.cost;
            best = Some(split);
        }
    }
    best
}

struct Sweep {
    cost: CutCost,
    axis: usize,
    sides: (f32, f32),
}

impl Sweep {
    /// The cheapest split along the axis that costs less than `limit`.
    fn run(&self, events: &[Event], begun: u32, count: u32, mut limit: f64) -> Option<Split> {
        let (min, max) = self.sides;
        let (min_wide, max_wide) = (f64::from(min), f64::from(max));
        let mut best = None;
        // Boxes that begin before the plane, boxes that end behind it; planar ones are in neither.
        let open = count - begun;
        let (mut left, mut right) = (open, count);
        let mut next = 0;
        while let Some(first) = events.get(next) {
            let group = next;
            let (mut begins, mut ends) = (first.begins(), first.ends());
            let mut planar = begins & ends;
            next += 1;
            while let Some(event) = events.get(next).filter(|event| event.key() == first.key()) {
                begins += event.begins();
                ends += event.ends();
                planar += event.begins() & event.ends();
                next += 1;
            }
            right -= ends;
            let position = first.position();
            let inside = min < position && position < max;
            if inside || planar > 0 {
                let wide = f64::from(position);
                let (lower, upper) = (wide - min_wide, max_wide - wide);
                // On the border only the boxes that lie in it can be split off; all others, clipped to the cell, lie on
                // its inner side, also those that go on beyond.
                let below = if position > min { left } else { 0 };
                let above = if position < max { right } else { 0 };
                let mut consider = |planar_left: bool, left_count: u32, right_count: u32| {
                    let cost = self.cost.at(lower, upper, left_count, right_count);
                    if cost < limit {
                        limit = cost;
                        best = Some(Split {
                            cost,
                            axis: self.axis,
                            position,
                            planar_left,
                            left: left_count,
                            right: right_count,
                            group: group..next,
                            begun: [left - open, left - open + begins],
                        });
                    }
                };
                if position < max {
                    consider(true, below + planar, above);
                }
                if position > min && planar > 0 {
                    consider(false, below, above + planar);
                }
            }
            left += begins;
        }
        best
    }
}
