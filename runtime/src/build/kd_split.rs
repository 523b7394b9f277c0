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

/// Where a sweep stands: of the node's boxes, `left` begin and all but `right` end before event `next`.
#[derive(Clone, Copy)]
struct Place {
    next: usize,
    left: u32,
    right: u32,
}

impl Sweep {
    /// The cheapest split along the axis that costs less than `limit`.
    ///
    /// On the border of the cell stand planar boxes only, so those are taken off at both ends first.
    fn run(&self, events: &[Event], begun: u32, count: u32, mut limit: f64) -> Option<Split> {
        let (min, max) = self.sides;
        let on_min = events.iter().take_while(|event| event.position() <= min).count();
        let on_max = events.iter().rev().take_while(|event| event.position() >= max).count();
        let open = count - begun;
        let mut best = None;
        if on_min > 0 {
            let flat = on_min as u32;
            let cost = self.cost_at(min, flat, count - flat);
            if cost < limit {
                limit = cost;
                let split = self.split(cost, min, true, [flat, count - flat]);
                best = Some(Split {
                    group: 0..on_min,
                    begun: [0, flat],
                    ..split
                });
            }
        }
        let start = Place {
            next: on_min,
            left: open + on_min as u32,
            right: count - on_min as u32,
        };
        if let Some(place) = self.cheapest_place(&events[..events.len() - on_max], start, limit) {
            let split = self.split_at(events, place, open);
            limit = split.cost;
            best = Some(split);
        }
        if on_max > 0 {
            let flat = on_max as u32;
            let cost = self.cost_at(max, count - flat, flat);
            if cost < limit {
                let split = self.split(cost, max, false, [count - flat, flat]);
                let group = events.len() - on_max..events.len();
                best = Some(Split {
                    group,
                    begun: [begun - flat, begun],
                    ..split
                });
            }
        }
        best
    }

    /// The first cheapest place inside the cell that costs less than `limit`.
    ///
    /// Each event is a candidate of its own, although only all events at a position together give the true counts. At a
    /// position, ends come first, then planar boxes, then beginnings: in between some boxes are counted on a side that
    /// they do not touch, or the planar ones are parted. With costs that are not negative and a bonus that is one, that
    /// never costs less than the better side for all; with others, the choice means nothing but stays a valid split.
    fn cheapest_place(&self, events: &[Event], start: Place, mut limit: f64) -> Option<Place> {
        let mut best = None;
        let Place {
            mut left, mut right, ..
        } = start;
        for (next, event) in events.iter().enumerate().skip(start.next) {
            let position = event.position();
            let planar = u32::from(event.is_planar());
            let mut cost = self.cost_at(position, left + planar, right - event.ends());
            if planar > 0 {
                cost = cost.min(self.cost_at(position, left, right));
            }
            if cost < limit {
                limit = cost;
                best = Some(Place { next, left, right });
            }
            left += event.begins();
            right -= event.ends();
        }
        best
    }

    /// The better split at the position of the event at `place`, with true counts.
    fn split_at(&self, events: &[Event], place: Place, open: u32) -> Split {
        let Place {
            next,
            mut left,
            mut right,
        } = place;
        let key = events[next].key();
        let before = events[..next].iter().rev().take_while(|event| event.key() == key);
        let mut begin = next;
        for event in before {
            left -= event.begins();
            right += event.ends();
            begin -= 1;
        }
        let (mut end, mut begins, mut planar) = (begin, 0, 0);
        for event in events[begin..].iter().take_while(|event| event.key() == key) {
            begins += event.begins();
            right -= event.ends();
            planar += u32::from(event.is_planar());
            end += 1;
        }
        let position = events[next].position();
        let cost_left = self.cost_at(position, left + planar, right);
        let cost_right = self.cost_at(position, left, right + planar);
        let split = if cost_right < cost_left {
            self.split(cost_right, position, false, [left, right + planar])
        } else {
            self.split(cost_left, position, true, [left + planar, right])
        };
        Split {
            group: begin..end,
            begun: [left - open, left - open + begins],
            ..split
        }
    }

    fn split(&self, cost: f64, position: f32, planar_left: bool, [left, right]: [u32; 2]) -> Split {
        Split {
            cost,
            axis: self.axis,
            position,
            planar_left,
            left,
            right,
            group: 0..0,
            begun: [0; 2],
        }
    }

    #[inline]
    fn cost_at(&self, position: f32, left: u32, right: u32) -> f64 {
        let position = f64::from(position);
        self.cost.at(
            position - f64::from(self.sides.0),
            f64::from(self.sides.1) - position,
            left,
            right,
        )
    }
}
