use super::KdTreeBuilder;
use super::fragment::{Fragment, bounds_of};
use super::growth::{OpenNode, empty_leaf, expected_weight};
use super::ranked::RankedCells;
use super::streamed_top::{Job, TopLevels};
use super::subtree::{BinRule, SubtreeBuilder};
use rayon::prelude::*;
use restpose_formats::rows::{KdNode, KdNodeRow};
use restpose_runtime::build::{CheckedBoxes, KdSettings, KdTree};

/// Builds kd-trees by streamed binning; owns most scratch memory.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.1.
///
/// Boxes are streamed in, counted in bins of all three axes at once, and sifted to the children clipped to their cells.
/// The largest nodes are cut at the borders of 1,024 bins over the cell, and the bins of both children are filled while
/// their parent is sifted. Small nodes are swept exactly: of at most 127 boxes, the positions of all sides have ranks in
/// eight bits, which take no sorted lists.
///
/// Differs from the thesis: empty space is cut off exactly at the boxes' sides, at any size; [`StreamedKd::new`] adapts
/// the number of bins to smaller nodes, moves planes to the sides of boxes, and makes leaves where little is to be gained.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads or on what was built before.
#[derive(Debug)]
pub struct StreamedKd {
    rule: BinRule,
    top: TopLevels,
    subtree: SubtreeBuilder,
}

/// Where the bins adapt, nodes of so many boxes are swept: fewer ranks to sweep at no loss of quality that matters.
pub(super) const ADAPTIVE_SWEEP: usize = 96;

/// A node of more fragments is worked off before its sub-trees are handed to threads: 1 MiB of fragments.
const TOP_NODE: usize = 1 << 15;

impl StreamedKd {
    /// The fast rule: bins as many as boxes, from 16 to 256, over the boxes' bounds; up to eight boxes are a leaf where
    /// they add next to nothing to what the tree is expected to cost.
    #[must_use]
    pub fn new() -> Self {
        Self::with(BinRule {
            adaptive: true,
            sweep_at: ADAPTIVE_SWEEP,
            stops: true,
        })
    }

    /// The thesis's rule: 1,024 bins over the cell down to the exact sweep.
    #[must_use]
    pub fn thesis() -> Self {
        Self::with(BinRule {
            adaptive: false,
            sweep_at: RankedCells::MAX_COUNT,
            stops: false,
        })
    }

    fn with(rule: BinRule) -> Self {
        Self {
            rule,
            top: TopLevels::default(),
            subtree: SubtreeBuilder::new(),
        }
    }

    /// Builds the sub-trees of the jobs, over `count` boxes, on all threads, and appends them in the order of the jobs.
    fn grow_jobs(&self, jobs: Vec<Job>, count: usize, settings: &KdSettings, tree: &mut KdTree) {
        let expected: f64 = jobs
            .iter()
            .map(|job| expected_weight(job.fragments.len(), &job.node.cell))
            .sum();
        let weight_per_box = expected / count as f64;
        let build = |builder: &mut SubtreeBuilder, job: Job| {
            let mut part = KdTree {
                nodes: vec![empty_leaf()],
                ..KdTree::default()
            };
            let index = job.node.index;
            *builder.fragments() = job.fragments;
            let node = OpenNode { index: 0, ..job.node };
            builder.grow(node, self.rule, weight_per_box, settings, &mut part);
            (index, part)
        };
        let parts: Vec<_> = jobs.into_par_iter().map_init(SubtreeBuilder::new, build).collect();
        for (index, part) in parts {
            append(index, &part, tree);
        }
    }
}

impl Default for StreamedKd {
    fn default() -> Self {
        Self::new()
    }
}

impl KdTreeBuilder for StreamedKd {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &KdSettings, tree: &mut KdTree) {
        let boxes = boxes.get();
        tree.nodes.clear();
        tree.references.clear();
        tree.nodes.push(empty_leaf());
        // Rows count no further; validation names what is not listed.
        let boxes = &boxes[..boxes.len().min(KdNodeRow::MAX_INDEX as usize)];
        let fragments = boxes.iter().zip(0..).map(|(bounds, id)| Fragment::of(bounds, id));
        if boxes.len() <= TOP_NODE {
            let list = self.subtree.fragments();
            list.clear();
            list.extend(fragments);
            tree.bounds = bounds_of(list);
            let root = OpenNode::root(tree.bounds, boxes.len());
            let weight_per_box = expected_weight(boxes.len(), &tree.bounds) / boxes.len() as f64;
            self.subtree.grow(root, self.rule, weight_per_box, settings, tree);
        } else {
            let jobs = self.top.grow(fragments, TOP_NODE, settings, tree);
            self.grow_jobs(jobs, boxes.len(), settings, tree);
        }
    }
}

/// Puts a tree in the place of the node `index`.
fn append(index: usize, part: &KdTree, tree: &mut KdTree) {
    // The part's root goes to `index`, its other nodes behind the tree's.
    let (nodes, references) = (tree.nodes.len() as u32 - 1, tree.references.len() as u32);
    let moved = part.nodes.iter().map(|row| {
        KdNodeRow::pack(match row.unpack() {
            KdNode::Leaf { first, count } => KdNode::Leaf {
                first: first + references,
                count,
            },
            KdNode::Inner { axis, split, left } => KdNode::Inner {
                axis,
                split,
                left: left + nodes,
            },
        })
    });
    let mut moved = moved;
    if let Some(root) = moved.next() {
        tree.nodes[index] = root;
        tree.nodes.extend(moved);
        tree.references.extend_from_slice(&part.references);
    }
}
