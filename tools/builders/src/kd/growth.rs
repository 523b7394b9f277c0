use super::cell_cost::half_area;
use super::fragment::{Fragment, sift};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, KdNodeRow, MAX_KD_DEPTH};
use restpose_runtime::build::{KdTree, MAX_REFERENCE_GROWTH};
use std::ops::Range;

/// A node whose place is taken but whose row is not yet written.
#[derive(Clone, Debug)]
pub(super) struct OpenNode {
    pub index: usize,
    pub depth: usize,
    pub cell: Aabb,
    /// References that its leaves may list in all.
    pub budget: u64,
}

/// When a node is not worth cutting, however cheap its best cut is: where it adds next to nothing to the tree's cost.
///
/// Scale matters and count does: a leaf of one or two boxes in a large cell costs more than dozens in small ones, and
/// leaves by count alone lose a tenth of the quality over an uneven scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop {
    /// The weight of all leaves that is expected of the tree, over its boxes. Zero stops at empty nodes only.
    pub weight_per_box: f64,
}

/// More fragments are never negligible, however little they weigh: rays that are aimed at small things, as a camera's are, meet
/// them more often than the surface area says.
const MOST_NEGLIGIBLE: usize = 8;

/// A node is negligible below this many weights per box, over the cube of its fragments: with each of them it has more to
/// gain, and a cut of one or two seldom gains what its price says. Loses up to 1.5 % of the expected cost and saves a third
/// of the nodes or more.
const NEGLIGIBLE: f64 = 24.0;

impl Stop {
    /// Whether a node of `count` fragments in `cell` is a leaf.
    #[inline]
    pub(super) fn here(&self, count: usize, cell: &Aabb) -> bool {
        let cube = (count as f64) * (count as f64) * (count as f64);
        count == 0 || count <= MOST_NEGLIGIBLE && cube * weight(count, cell) < NEGLIGIBLE * self.weight_per_box
    }
}

/// What the leaves below a node of `count` fragments in `cell` are expected to weigh: of boxes that are spread evenly and
/// do not overlap, a ray meets the cube root.
pub(super) fn expected_weight(count: usize, cell: &Aabb) -> f64 {
    weight(1, cell) * libm::cbrt(count as f64)
}

/// Half the surface area of `cell` times `count`: what the tests of a leaf add to the tree's expected cost.
#[inline]
pub(super) fn weight(count: usize, cell: &Aabb) -> f64 {
    let side = std::array::from_fn(|k| f64::from(cell.max[k]) - f64::from(cell.min[k]));
    half_area(side) * count as f64
}

impl OpenNode {
    pub(super) fn root(cell: Aabb, count: usize) -> Self {
        Self {
            index: 0,
            depth: 0,
            cell,
            budget: (count as u64 * u64::from(MAX_REFERENCE_GROWTH)).min(u64::from(KdNodeRow::MAX_INDEX)),
        }
    }

    /// Whether the tree has room for `cut` below this node.
    pub(super) fn allows(&self, references: usize) -> bool {
        self.depth < MAX_KD_DEPTH && references as u64 <= self.budget
    }

    /// Makes the node a leaf of `fragments`.
    pub(super) fn close(&self, fragments: &[Fragment], tree: &mut KdTree) {
        tree.nodes[self.index] = KdNodeRow::pack(KdNode::Leaf {
            first: tree.references.len() as u32,
            count: fragments.len() as u32,
        });
        tree.references.extend(fragments.iter().map(Fragment::id));
    }

    /// Makes the node an inner one, and takes the places of two children with `left` and `right` fragments.
    pub(super) fn cut(&self, axis: usize, position: f32, left: usize, right: usize, tree: &mut KdTree) -> [Self; 2] {
        let first = tree.nodes.len();
        tree.nodes[self.index] = KdNodeRow::pack(KdNode::Inner {
            axis,
            split: position,
            left: first as u32,
        });
        tree.nodes.extend([empty_leaf(); 2]);
        let (mut lower, mut upper) = (self.cell, self.cell);
        lower.max[axis] = position;
        upper.min[axis] = position;
        // Shares in proportion to the fragments: a child that cuts without doubling any always can.
        let lower_budget = if right == 0 {
            self.budget
        } else {
            self.budget * left as u64 / (left + right) as u64
        };
        let depth = self.depth + 1;
        [
            Self {
                index: first,
                depth,
                cell: lower,
                budget: lower_budget,
            },
            Self {
                index: first + 1,
                depth,
                cell: upper,
                budget: self.budget - lower_budget,
            },
        ]
    }

    /// Cuts empty space off; the node becomes the child that is left.
    pub(super) fn shrink(&mut self, axis: usize, position: f32, below: bool, count: usize, tree: &mut KdTree) {
        let [lower, upper] = if below {
            self.cut(axis, position, 0, count, tree)
        } else {
            self.cut(axis, position, count, 0, tree)
        };
        *self = if below { upper } else { lower };
    }
}

/// Holds the place of a node that is still open, and is what an empty one becomes.
pub(super) fn empty_leaf() -> KdNodeRow {
    KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 })
}

/// The fragments of all open nodes: a stack of ranges, that of the node in work on top.
#[derive(Debug, Default)]
pub(super) struct FragmentStack {
    pub list: Vec<Fragment>,
    spare: Vec<Fragment>,
}

impl FragmentStack {
    /// Parts the topmost range; the right child's is on top of the left one's.
    pub(super) fn part(&mut self, range: Range<usize>, plane: super::fragment::Plane) -> [Range<usize>; 2] {
        let begin = range.start;
        if self.spare.len() < range.len() {
            self.spare.resize(range.len(), Fragment::default());
        }
        let [left, right] = sift(&mut self.list[range], &mut self.spare, plane);
        let (middle, end) = (begin + left, begin + left + right);
        if self.list.len() < end {
            self.list.resize(end, Fragment::default());
        }
        self.list[middle..end].copy_from_slice(&self.spare[..right]);
        [begin..middle, middle..end]
    }
}
