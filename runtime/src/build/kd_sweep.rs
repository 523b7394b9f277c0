//! The exact SAH kd-tree builder in O(n log n).
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.1.2; Wald and Havran, *On building fast kd-trees for
//! ray tracing, and on doing that in O(N log N)*, 2006.
//!
//! Each axis has one sorted list of the places where boxes begin and end. A node owns a range of each list and a list
//! of its boxes. Along the split axis, the events below the plane are the left child's and those above it the right
//! child's: nothing moves. A box that straddles the plane keeps its beginning on the left and its end on the right; that
//! it goes on to the border of the cell needs no event, so boxes are always clipped to their cell. Along the other two
//! axes events are sifted by the side of their box, and those of straddling boxes doubled.
//!
//! Differs from Wald and Havran: the pieces of a box never begin or end anywhere new, so no events are made, sorted or
//! merged after the start.
//!
//! Nodes are worked off depth first, right children before left ones: the ranges form stacks, and the range in work is
//! on top of each.

use super::finite_box::finite_box;
use super::kd_event::{Event, sort_events};
use super::kd_split::{EventRange, Split, cheapest_split};
use super::kd_tree::KdTree;
use super::sah::KdSettings;
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, KdNodeRow, MAX_KD_DEPTH};
use std::ops::Range;

/// A tree lists at most this many references per box that is not empty.
///
/// Each node may spend its own share: where the boxes along a path from the root would be doubled beyond this factor,
/// the path ends in a leaf. Boxes that overlap each other like stairs would otherwise be listed a quadratic number of
/// times.
pub const MAX_REFERENCE_GROWTH: u32 = 32;

/// Builds kd-trees over boxes by the exact surface area heuristic; owns all scratch memory.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on what was built before; a build whose boxes need
/// no more room than an earlier one allocates nothing.
#[derive(Debug, Default)]
pub struct KdBuilder {
    /// Boxes as finite intervals, per axis.
    intervals: [Vec<[f32; 2]>; 3],
    /// Sorted events per axis: the stack of the open nodes' ranges.
    lists: [Vec<Event>; 3],
    /// The stack of the open nodes' boxes, each range ascending.
    ids: Vec<u32>,
    /// Where each box of the node in work goes.
    sides: Vec<Side>,
    open: Vec<OpenNode>,
    spare_events: Vec<Event>,
    spare_ids: Vec<u32>,
}

/// A node whose place is taken but whose row is not yet written.
#[derive(Clone, Debug)]
struct OpenNode {
    index: usize,
    depth: usize,
    cell: Aabb,
    ids: Range<usize>,
    events: [EventRange; 3],
    /// References that its leaves may list in all.
    budget: u64,
}

/// The children that a box goes to, as counts.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    left: u8,
    right: u8,
}

impl KdBuilder {
    /// A builder that owns no memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces `tree` by the tree over `boxes`. What it promises stands at [`KdTree`].
    ///
    /// A node becomes a leaf where no split is cheaper by Eq. 4.3, at [`MAX_KD_DEPTH`], or where its references would
    /// exceed its share of [`MAX_REFERENCE_GROWTH`]. The split is the cheapest of all planes through sides of boxes;
    /// of equal ones the lowest axis, then the lowest position, then boxes in the plane left.
    ///
    /// Node rows can count to [`KdNodeRow::MAX_INDEX`] boxes; keeping below is up to the caller. With more, the tree
    /// lists none, and [`KdTree::validate`] says so.
    ///
    /// Ends on any boxes and settings. Complexity: O(n log n) for a tree with O(n) references.
    pub fn build(&mut self, boxes: &[Aabb], settings: &KdSettings, tree: &mut KdTree) {
        tree.nodes.clear();
        tree.references.clear();
        tree.nodes.push(empty_leaf());
        tree.bounds = self.start(boxes);
        while let Some(node) = self.open.pop() {
            match self.split_of(&node, settings, tree.nodes.len()) {
                Some(split) => {
                    let left = tree.nodes.len();
                    tree.nodes[node.index] = KdNodeRow::pack(KdNode::Inner {
                        axis: split.axis,
                        split: split.position,
                        left: left as u32,
                    });
                    tree.nodes.extend([empty_leaf(); 2]);
                    self.part(&node, &split, left);
                }
                None => {
                    tree.nodes[node.index] = KdNodeRow::pack(KdNode::Leaf {
                        first: tree.references.len() as u32,
                        count: node.ids.len() as u32,
                    });
                    tree.references.extend_from_slice(&self.ids[node.ids]);
                }
            }
        }
    }

    /// Fills all lists for the root, opens it, and returns its cell.
    fn start(&mut self, boxes: &[Aabb]) -> Aabb {
        self.ids.clear();
        self.open.clear();
        for k in 0..3 {
            self.intervals[k].clear();
            self.lists[k].clear();
        }
        let boxes = if boxes.len() <= KdNodeRow::MAX_INDEX as usize {
            boxes
        } else {
            &[]
        };
        let mut cell = Aabb::EMPTY;
        for (id, bounds) in boxes.iter().enumerate() {
            let bounds = finite_box(bounds);
            if let Some(bounds) = bounds {
                self.ids.push(id as u32);
                cell = cell.union(bounds);
            }
            for k in 0..3 {
                self.intervals[k].push(bounds.map_or([0.0; 2], |b| [b.min[k], b.max[k]]));
            }
        }
        grow(&mut self.sides, boxes.len());
        let events = std::array::from_fn(|k| {
            let begun = self.push_events(k, [cell.min[k], cell.max[k]]);
            sort_events(&mut self.lists[k], &mut self.spare_events);
            EventRange {
                begin: 0,
                end: self.lists[k].len(),
                begun,
            }
        });
        let ids = 0..self.ids.len();
        let budget = (ids.len() as u64 * u64::from(MAX_REFERENCE_GROWTH)).min(u64::from(KdNodeRow::MAX_INDEX));
        self.open.push(OpenNode {
            index: 0,
            depth: 0,
            cell,
            ids,
            events,
            budget,
        });
        cell
    }

    /// Appends the events of all boxes along `axis`; the number of those that begin a box.
    fn push_events(&mut self, axis: usize, cell: [f32; 2]) -> u32 {
        let mut begun = 0;
        for &id in &self.ids {
            for event in Event::of(id, self.intervals[axis][id as usize], cell) {
                begun += event.begins();
                self.lists[axis].push(event);
            }
        }
        begun
    }

    /// The split of `node`; `None` when it becomes a leaf.
    fn split_of(&self, node: &OpenNode, settings: &KdSettings, node_count: usize) -> Option<Split> {
        if node.depth == MAX_KD_DEPTH || node_count + 2 > KdNodeRow::MAX_INDEX as usize {
            return None;
        }
        let count = node.ids.len() as u32;
        cheapest_split(&self.lists, &node.events, &node.cell, count, settings)
            .filter(|split| u64::from(split.left) + u64::from(split.right) <= node.budget)
    }

    /// Opens the children of `node`, at `left` and behind it.
    fn part(&mut self, node: &OpenNode, split: &Split, left: usize) {
        self.classify(node, split);
        let (left_ids, right_ids) = self.sift_ids(node.ids.clone());
        let mut events = [[EventRange::default(); 2]; 3];
        for (axis, children) in events.iter_mut().enumerate() {
            *children = if axis == split.axis {
                part_at_plane(&mut self.lists[axis], node.events[axis], split)
            } else {
                sift_events(
                    &mut self.lists[axis],
                    node.events[axis],
                    &self.sides,
                    &mut self.spare_events,
                )
            };
        }
        let (mut lower, mut upper) = (node.cell, node.cell);
        lower.max[split.axis] = split.position;
        upper.min[split.axis] = split.position;
        // Shares in proportion to the boxes: a child that splits without doubling any always can.
        let (l, r) = (left_ids.len() as u64, right_ids.len() as u64);
        let left_budget = node.budget * l / (l + r).max(1);
        let depth = node.depth + 1;
        self.open.push(OpenNode {
            index: left,
            depth,
            cell: lower,
            ids: left_ids,
            events: events.map(|[left, _]| left),
            budget: left_budget,
        });
        self.open.push(OpenNode {
            index: left + 1,
            depth,
            cell: upper,
            ids: right_ids,
            events: events.map(|[_, right]| right),
            budget: node.budget - left_budget,
        });
    }

    /// Decides for each box of the node, clipped to the cell, which children it goes to.
    fn classify(&mut self, node: &OpenNode, split: &Split) {
        let (lo, hi) = (node.cell.min[split.axis], node.cell.max[split.axis]);
        let intervals = &self.intervals[split.axis];
        for &id in &self.ids[node.ids.clone()] {
            let [min, max] = intervals[id as usize];
            let below = min.max(lo) < split.position;
            let above = max.min(hi) > split.position;
            let planar = !below && !above;
            self.sides[id as usize] = Side {
                left: u8::from(below || planar && split.planar_left),
                right: u8::from(above || planar && !split.planar_left),
            };
        }
    }

    /// Parts the node's boxes by their sides; the right child's are on top.
    fn sift_ids(&mut self, range: Range<usize>) -> (Range<usize>, Range<usize>) {
        let begin = range.start;
        grow(&mut self.spare_ids, range.len());
        let (mut left, mut right) = (0, 0);
        {
            let (ids, spare) = (&mut self.ids[range.clone()], &mut self.spare_ids[..range.len()]);
            for next in 0..ids.len() {
                let id = ids[next];
                let side = self.sides[id as usize];
                ids[left] = id;
                left += usize::from(side.left);
                spare[right] = id;
                right += usize::from(side.right);
            }
        }
        let (middle, end) = (begin + left, begin + left + right);
        grow(&mut self.ids, end);
        self.ids[middle..end].copy_from_slice(&self.spare_ids[..right]);
        (begin..middle, middle..end)
    }
}

#[cfg(test)]
impl KdBuilder {
    /// Capacities of all scratch buffers.
    pub(super) fn capacities(&self) -> Vec<usize> {
        let per_axis = (0..3).flat_map(|k| [self.intervals[k].capacity(), self.lists[k].capacity()]);
        let rest = [
            self.ids.capacity(),
            self.sides.capacity(),
            self.open.capacity(),
            self.spare_events.capacity(),
            self.spare_ids.capacity(),
        ];
        per_axis.chain(rest).collect()
    }
}

/// Holds the place of a node that is still open.
fn empty_leaf() -> KdNodeRow {
    KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 })
}

/// Parts the events along the split axis. Those at the plane are dropped, but for planar boxes: what ends there goes on
/// to the border of the left cell, what begins there begins at that of the right one.
fn part_at_plane(list: &mut [Event], range: EventRange, split: &Split) -> [EventRange; 2] {
    let group = range.begin + split.group.start..range.begin + split.group.end;
    let [begun_before, begun_through] = split.begun;
    let mut left = EventRange {
        begin: range.begin,
        end: group.start,
        begun: begun_before,
    };
    let mut right = EventRange {
        begin: group.end,
        end: range.end,
        begun: range.begun - begun_through,
    };
    if split.planar_left {
        for next in group {
            if list[next].is_planar() {
                list[left.end] = list[next];
                left.end += 1;
                left.begun += 1;
            }
        }
    } else {
        for next in group.rev() {
            if list[next].is_planar() {
                right.begin -= 1;
                right.begun += 1;
                list[right.begin] = list[next];
            }
        }
    }
    [left, right]
}

/// Parts the events along another axis by the sides of their boxes, in order; the right child's are on top.
fn sift_events(list: &mut Vec<Event>, range: EventRange, sides: &[Side], spare: &mut Vec<Event>) -> [EventRange; 2] {
    let EventRange { begin, end, .. } = range;
    grow(spare, end - begin);
    let (mut left, mut right) = (0, 0);
    let mut begun = [0; 2];
    {
        let (events, spare) = (&mut list[begin..end], &mut spare[..end - begin]);
        // Writing before deciding keeps the loop free of branches that depend on the data.
        for next in 0..events.len() {
            let event = events[next];
            let side = sides[event.id()];
            events[left] = event;
            left += usize::from(side.left);
            begun[0] += event.begins() * u32::from(side.left);
            spare[right] = event;
            right += usize::from(side.right);
            begun[1] += event.begins() * u32::from(side.right);
        }
    }
    let (middle, end) = (begin + left, begin + left + right);
    grow(list, end);
    list[middle..end].copy_from_slice(&spare[..right]);
    [
        EventRange {
            begin,
            end: middle,
            begun: begun[0],
        },
        EventRange {
            begin: middle,
            end,
            begun: begun[1],
        },
    ]
}

/// Makes `list` at least `len` long.
fn grow<T: Clone + Default>(list: &mut Vec<T>, len: usize) {
    if list.len() < len {
        list.resize(len, T::default());
    }
}
