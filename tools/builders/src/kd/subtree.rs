use super::bins::Bins;
use super::cell_cost::CellCost;
use super::cut::{Cut, cheapest_cut};
use super::fragment::{Fragment, bounds_of};
use super::growth::{FragmentStack, OpenNode, Stop, expected_weight};
use super::ranked::RankedCells;
use restpose_formats::rows::KdNodeRow;
use restpose_runtime::build::{KdSettings, KdTree};
use std::ops::Range;

/// How a builder lays its bins, and when it stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BinRule {
    /// Bins that follow the number of fragments, over their bounds; else [`Bins::MAX_COUNT`] over the cell.
    pub adaptive: bool,
    /// A node of at most so many fragments is swept exactly.
    pub sweep_at: usize,
    /// Leaves below swept nodes where little is to be gained.
    pub stops: bool,
}

/// Builds the part of a tree below a node, depth first; owns all scratch memory.
#[derive(Debug)]
pub(super) struct SubtreeBuilder {
    stack: FragmentStack,
    open: Vec<(OpenNode, Range<usize>)>,
    bins: Bins,
    ranked: RankedCells,
}

impl SubtreeBuilder {
    pub(super) fn new() -> Self {
        Self {
            stack: FragmentStack::default(),
            open: Vec::new(),
            bins: Bins::new(),
            ranked: RankedCells::new(),
        }
    }

    /// The fragments that [`SubtreeBuilder::grow`] works on, to be filled by the caller.
    pub(super) fn fragments(&mut self) -> &mut Vec<Fragment> {
        &mut self.stack.list
    }

    /// Grows the sub-tree of `node` over all fragments, which must lie in its cell, in ascending order.
    /// All of the tree's leaves are expected to weigh `weight_per_box` times its boxes.
    pub(super) fn grow(
        &mut self,
        node: OpenNode,
        rule: BinRule,
        weight_per_box: f64,
        settings: &KdSettings,
        tree: &mut KdTree,
    ) {
        let (mut found, mut expected) = (0.0, 0.0);
        let count = self.stack.list.len();
        self.open.push((node, 0..count));
        while let Some((node, range)) = self.open.pop() {
            let count = range.len();
            if count <= rule.sweep_at {
                // Boxes that overlap weigh more than expected; by how much, the nodes swept so far tell.
                let excess = if expected > 0.0 { found / expected } else { 1.0 };
                let weight_per_box = if rule.stops { weight_per_box * excess } else { 0.0 };
                let stop = Stop { weight_per_box };
                expected += expected_weight(count, &node.cell);
                found += self.ranked.grow(node, &self.stack.list[range], settings, stop, tree);
            } else {
                self.split(node, range, rule, settings, tree);
            }
        }
    }

    /// Cuts off empty space while that is cheapest, then opens both children of `node`, or makes it a leaf.
    fn split(
        &mut self,
        mut node: OpenNode,
        range: Range<usize>,
        rule: BinRule,
        settings: &KdSettings,
        tree: &mut KdTree,
    ) {
        let count = range.len();
        let bounds = bounds_of(&self.stack.list[range.clone()]);
        let mut laid = false;
        loop {
            let fragments = &self.stack.list[range.clone()];
            if rule.adaptive && !laid {
                self.bins.lay_adaptive(&bounds, count);
                self.bins.add(fragments);
                laid = true;
            } else if !rule.adaptive {
                self.bins.lay(&node.cell, Bins::MAX_COUNT);
                self.bins.add(fragments);
            }
            let cost = CellCost::new(&node.cell, settings);
            let room = tree.nodes.len() + 2 <= KdNodeRow::MAX_INDEX as usize;
            let cut = cheapest_cut(fragments, &node.cell, &bounds, &self.bins, &cost, rule.adaptive)
                .map(|priced| priced.cut)
                .filter(|cut| room && node.allows(cut.references(count)));
            match cut {
                None => {
                    node.close(fragments, tree);
                    return;
                }
                Some(Cut::EmptyBelow { axis, position }) => node.shrink(axis, position, true, count, tree),
                Some(Cut::EmptyAbove { axis, position }) => node.shrink(axis, position, false, count, tree),
                Some(Cut::Part { plane, .. }) => {
                    let [left, right] = self.stack.part(range, plane);
                    let [lower, upper] = node.cut(plane.axis, plane.position, left.len(), right.len(), tree);
                    self.open.push((lower, left));
                    self.open.push((upper, right));
                    return;
                }
            }
        }
    }
}
