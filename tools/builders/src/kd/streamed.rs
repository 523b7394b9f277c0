use super::KdTreeBuilder;
use super::fragment::{Fragment, bounds_of};
use super::growth::{OpenNode, Stop, empty_leaf};
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

/// Share of a swept node's tests below which a node in it is not worth splitting. Loses about 1 % of the expected cost and
/// makes a third less nodes, of uneven geometry half.
const NEGLIGIBLE_SHARE: f64 = 1.0 / 900.0;

/// A node of more fragments is worked off before its sub-trees are handed to threads: 1 MiB of fragments.
const TOP_NODE: usize = 1 << 15;

impl StreamedKd {
    /// The fast rule: bins as many as boxes, from 16 to 256, over the boxes' bounds; three boxes are a leaf, and so are more
    /// whose tests are less than 1/900 of those of the swept node around them.
    #[must_use]
    pub fn new() -> Self {
        Self::with(BinRule {
            adaptive: true,
            sweep_at: ADAPTIVE_SWEEP,
            stop: Stop {
                count: 3,
                weight: 0.0,
                swept_share: NEGLIGIBLE_SHARE,
            },
        })
    }

    /// The thesis's rule: 1,024 bins over the cell down to the exact sweep.
    #[must_use]
    pub fn thesis() -> Self {
        Self::with(BinRule {
            adaptive: false,
            sweep_at: RankedCells::MAX_COUNT,
            stop: Stop::default(),
        })
    }

    fn with(rule: BinRule) -> Self {
        Self {
            rule,
            top: TopLevels::default(),
            subtree: SubtreeBuilder::new(),
        }
    }

    /// Builds the sub-trees of the jobs on all threads, and appends them in the order of the jobs.
    fn grow_jobs(&self, jobs: Vec<Job>, settings: &KdSettings, tree: &mut KdTree) {
        let build = |builder: &mut SubtreeBuilder, job: Job| {
            let mut part = KdTree {
                nodes: vec![empty_leaf()],
                ..KdTree::default()
            };
            let index = job.node.index;
            *builder.fragments() = job.fragments;
            let node = OpenNode { index: 0, ..job.node };
            builder.grow(node, self.rule, settings, &mut part);
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
            self.subtree.grow(root, self.rule, settings, tree);
        } else {
            let jobs = self.top.grow(fragments, TOP_NODE, settings, tree);
            self.grow_jobs(jobs, settings, tree);
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
