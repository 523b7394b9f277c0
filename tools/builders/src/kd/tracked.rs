use super::KdTreeBuilder;
use super::cell_cost::CellCost;
use super::cut::{Cut, cheapest_gap};
use super::fragment::{Fragment, bounds_of};
use super::growth::{FragmentStack, OpenNode, Stop, empty_leaf, weight};
use super::kalman::Kalman;
use super::plane_search::{FoundPlane, PlaneSearch};
use super::ranked::RankedCells;
use super::tracking_stats::TrackingStats;
use restpose_formats::geom::Aabb;
use restpose_formats::rows::KdNodeRow;
use restpose_runtime::build::{CheckedBoxes, KdSettings, KdTree, sah_cost};
use std::ops::Range;

/// Builds the kd-trees of an animation, frame after frame: each node's plane is searched from where a Kalman filter expects
/// it. Owns all scratch memory.
///
/// Source: Hussain and Grahn, *Tracking Data Structures Coherency in Animated Ray Tracing for Real-Time 3D-Rendering*.
///
/// Each node above [`TrackedKd::SWEEP_AT`] boxes keeps a filter, its axis and its place in the tree, which is its path
/// from the root and so its depth. In the next frame the minimum of the cost along that axis is searched from the
/// prediction. A node keeps its axis while its cut stays as good, compared to a leaf, as it was; else, and where the
/// tree has a new node, all axes are searched. The tree is built from scratch: boxes are sifted anew in each frame.
///
/// Differs from the paper: positions are tracked relative to the box around the node's boxes, which moves with them; the
/// axis is chosen as said, where the paper says not; the filter measures the planes found, without the paper's random
/// noise, so a build is repeatable; empty space is cut off at the boxes' sides, small nodes are swept exactly, and nodes
/// whose share of the expected cost is negligible become leaves. [`TrackedKd::new`] searches by bins where there is no
/// prediction, [`TrackedKd::paper`] from the extremes of each axis.
///
/// Guarantee: trees depend on the boxes and settings since the first frame alone.
// Tried on the papers' gallops, to get beyond two thirds of the exact builder's time saved, at 97.7 % of its quality: to
// search nothing, and cut every node at the side of the very box that gave its plane in the last frame, with a new search
// where that side lies outside of the cell. It saved 74 % (80 % with poor leaves in the place of new searches) at 92 to
// 94 % where every other frame was built anew, and 83 to 87 % where every eighth was: a plane of a small node does not last
// a frame of these motions. Exact sweeps from 40 boxes down in the place of 64 saved no more and lost 0.4 %.
#[derive(Debug)]
pub struct TrackedKd {
    from_extremes: bool,
    known: Vec<KnownNode>,
    grown: Vec<KnownNode>,
    frames: u32,
    /// Half the tree's surface area times its expected cost in tests, steps included, over its boxes.
    tests_per_box: f64,
    stack: FragmentStack,
    open: Vec<OpenTracked>,
    search: PlaneSearch,
    ranked: RankedCells,
    stats: TrackingStats,
}

/// An inner node of the last frame's tree, below which the search is tracked.
#[derive(Clone, Copy, Debug)]
struct KnownNode {
    axis: usize,
    /// Its cost over that of a leaf.
    ratio: f32,
    filter: Kalman,
    children: [Option<u32>; 2],
}

#[derive(Debug)]
struct OpenTracked {
    node: OpenNode,
    range: Range<usize>,
    known: Option<u32>,
    /// The node of this frame's tree above it, and the side.
    above: Option<(u32, usize)>,
}

/// Leaves may weigh so many times their share of the tree's expected cost, which steps add to: a tree of one frame has fewer
/// rays to earn its nodes. Loses half a percent of the expected cost and saves an eighth of the nodes.
const COARSER: f64 = 2.0;

/// A tracked cut may be dearer, compared to a leaf, by this factor before all axes are searched.
const SLACK: f32 = 1.05;

/// The tests per box are measured anew after so many frames.
const COST_FRAMES: u32 = 16;

impl TrackedKd {
    /// Nodes of at most so many boxes are swept exactly.
    pub const SWEEP_AT: usize = 64;

    /// A builder that searches by bins where it has no prediction.
    #[must_use]
    pub fn new() -> Self {
        Self::with(false)
    }

    /// A builder that searches from the extremes of all axes where it has no prediction, as the paper does.
    #[must_use]
    pub fn paper() -> Self {
        Self::with(true)
    }

    fn with(from_extremes: bool) -> Self {
        Self {
            from_extremes,
            known: Vec::new(),
            grown: Vec::new(),
            frames: 0,
            tests_per_box: 0.0,
            stack: FragmentStack::default(),
            open: Vec::new(),
            search: PlaneSearch::new(),
            ranked: RankedCells::new(),
            stats: TrackingStats::default(),
        }
    }

    /// Of the last build.
    #[must_use]
    pub fn stats(&self) -> &TrackingStats {
        &self.stats
    }

    /// Starts a new animation: the next build is a first frame.
    pub fn forget(&mut self) {
        self.known.clear();
        self.frames = 0;
        self.tests_per_box = 0.0;
    }

    fn measure(&mut self, count: usize, settings: &KdSettings, tree: &KdTree) {
        let tests = sah_cost(&tree.nodes, &tree.bounds, settings) / settings.intersection_cost;
        let per_box = weight(1, &tree.bounds) * tests / count as f64;
        self.tests_per_box = if per_box.is_finite() { per_box } else { 0.0 };
    }

    /// Cuts off empty space while that is cheapest, then opens both children of a node, or makes it a leaf.
    fn split(&mut self, open: OpenTracked, settings: &KdSettings, tree: &mut KdTree) {
        let OpenTracked {
            mut node,
            range,
            known,
            above,
        } = open;
        let known = known.map(|index| self.known[index as usize]);
        let count = range.len();
        let bounds = bounds_of(&self.stack.list[range.clone()]);
        loop {
            let cost = CellCost::new(&node.cell, settings);
            let leaf = cost.leaf(count);
            let gap = cheapest_gap(&node.cell, &bounds, &cost, count, leaf);
            // What is cheaper than the node's last cut is likely to be so than its next one, which need not be searched.
            let clear = gap.filter(|gap| known.is_some_and(|known| gap.cost < known.ratio * leaf));
            let found = match clear {
                Some(_) => None,
                None => self.find(range.clone(), &bounds, &cost, known),
            };
            let limit = gap.map_or(leaf, |gap| gap.cost);
            let found = found.filter(|(found, _)| found.priced.cost < limit);
            let cut = found.map_or(gap.map(|gap| gap.cut), |(found, _)| Some(found.priced.cut));
            let room = tree.nodes.len() + 2 <= KdNodeRow::MAX_INDEX as usize;
            match (cut.filter(|cut| room && node.allows(cut.references(count))), found) {
                (Some(Cut::EmptyBelow { axis, position }), _) => node.shrink(axis, position, true, count, tree),
                (Some(Cut::EmptyAbove { axis, position }), _) => node.shrink(axis, position, false, count, tree),
                (Some(Cut::Part { plane, .. }), Some((found, filter))) => {
                    let same = known.filter(|known| known.axis == plane.axis);
                    let children = same.map_or([None; 2], |known| known.children);
                    let grown = self.keep(above, plane.axis, found.priced.cost / leaf, filter);
                    let [left, right] = self.stack.part(range, plane);
                    let nodes = node.cut(plane.axis, plane.position, left.len(), right.len(), tree);
                    for (side, (node, range)) in nodes.into_iter().zip([left, right]).enumerate() {
                        self.open.push(OpenTracked {
                            node,
                            range,
                            known: children[side],
                            above: Some((grown, side)),
                        });
                    }
                    return;
                }
                _ => {
                    node.close(&self.stack.list[range], tree);
                    return;
                }
            }
        }
    }

    /// The plane of a node and its filter, corrected by it.
    fn find(
        &mut self,
        range: Range<usize>,
        bounds: &Aabb,
        cost: &CellCost,
        known: Option<KnownNode>,
    ) -> Option<(FoundPlane, Kalman)> {
        let fragments = &self.stack.list[range];
        if let Some(KnownNode {
            axis,
            ratio,
            mut filter,
            ..
        }) = known
        {
            let predicted = filter.predicted();
            let (found, steps) = self.search.near(fragments, bounds, cost, axis, predicted);
            let limit = SLACK * ratio * cost.leaf(fragments.len());
            if let Some(found) = found.filter(|found| found.priced.cost <= limit) {
                self.stats.tracked_nodes += 1;
                self.stats.tracked_steps += steps;
                self.stats.error_sum += f64::from((found.share - predicted).abs());
                filter.advance(found.share);
                return Some((found, filter));
            }
            self.stats.untracked_steps += steps;
        }
        self.stats.untracked_nodes += 1;
        let found = if self.from_extremes {
            let (found, steps) = self.search.over_all_axes(fragments, bounds, cost);
            self.stats.untracked_steps += steps;
            found
        } else {
            self.search.by_bins(fragments, bounds, cost)
        };
        found.map(|found| (found, Kalman::new(found.share)))
    }

    /// Adds a node to what the next frame knows.
    fn keep(&mut self, above: Option<(u32, usize)>, axis: usize, ratio: f32, filter: Kalman) -> u32 {
        let index = self.grown.len() as u32;
        self.grown.push(KnownNode {
            axis,
            ratio,
            filter,
            children: [None; 2],
        });
        if let Some((parent, side)) = above {
            self.grown[parent as usize].children[side] = Some(index);
        }
        index
    }
}

impl Default for TrackedKd {
    fn default() -> Self {
        Self::new()
    }
}

impl KdTreeBuilder for TrackedKd {
    /// Replaces `tree` by the tree of the animation's next frame, whose boxes are those of the last one, moved. With
    /// other boxes the tree is as valid, and slower to build.
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &KdSettings, tree: &mut KdTree) {
        let boxes = boxes.get();
        tree.nodes.clear();
        tree.references.clear();
        tree.nodes.push(empty_leaf());
        self.stats = TrackingStats::default();
        // Rows count no further; validation names what is not listed.
        let boxes = &boxes[..boxes.len().min(KdNodeRow::MAX_INDEX as usize)];
        let list = &mut self.stack.list;
        list.clear();
        list.extend(boxes.iter().zip(0..).map(|(bounds, id)| Fragment::of(bounds, id)));
        tree.bounds = bounds_of(list);
        let stop = Stop {
            weight_per_box: COARSER * self.tests_per_box,
        };
        self.grown.clear();
        self.open.push(OpenTracked {
            node: OpenNode::root(tree.bounds, boxes.len()),
            range: 0..boxes.len(),
            known: (!self.known.is_empty()).then_some(0),
            above: None,
        });
        while let Some(open) = self.open.pop() {
            let fragments = &self.stack.list[open.range.clone()];
            if stop.here(fragments.len(), &open.node.cell) {
                open.node.close(fragments, tree);
            } else if fragments.len() <= Self::SWEEP_AT {
                self.ranked.grow(open.node, fragments, settings, stop, tree);
            } else {
                self.split(open, settings, tree);
            }
        }
        std::mem::swap(&mut self.known, &mut self.grown);
        if self.frames.is_multiple_of(COST_FRAMES) {
            self.measure(boxes.len(), settings, tree);
        }
        self.frames = self.frames.wrapping_add(1);
    }
}
