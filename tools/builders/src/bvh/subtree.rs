use super::bins::{Bins, Projection};
use super::depth_limit::{must_halve, sort_into_halves};
use super::measure::Measure;
use super::primitive::{Extent, Primitive, write_references};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{BvhNode, BvhSettings};

/// Nodes with so many primitives or fewer become leaves: of the 2 or 4 of Wald 2007, §3.8, that whose trees cost 5 to 10 %
/// less, for 15 to 30 % more time.
pub const DEFAULT_LEAF_SIZE: usize = 2;

/// Primitives that one node will contain, and the part of the tree's references that is theirs.
#[derive(Debug)]
pub(super) struct Span<'a> {
    pub(super) primitives: &'a mut [Primitive],
    pub(super) references: &'a mut [u32],
    /// Place of the first reference in the tree.
    pub(super) first: u32,
    /// Inner nodes above.
    pub(super) depth: usize,
}

impl<'a> Span<'a> {
    pub(super) fn root(primitives: &'a mut [Primitive], references: &'a mut [u32]) -> Self {
        Self {
            primitives,
            references,
            first: 0,
            depth: 0,
        }
    }

    /// The same with primitives from elsewhere, and those that it had.
    pub(super) fn with_primitives(self, primitives: &'a mut [Primitive]) -> (Self, &'a mut [Primitive]) {
        (Self { primitives, ..self }, self.primitives)
    }

    /// Two children, the left one with `count` primitives.
    pub(super) fn split_at(self, count: usize) -> [Self; 2] {
        let (left, right) = self.primitives.split_at_mut(count);
        let (left_references, right_references) = self.references.split_at_mut(count);
        let depth = self.depth + 1;
        [
            Span {
                primitives: left,
                references: left_references,
                first: self.first,
                depth,
            },
            Span {
                primitives: right,
                references: right_references,
                first: self.first + count as u32,
                depth,
            },
        ]
    }

    /// The leaf that lists all.
    pub(super) fn into_leaf(self, extent: &Extent) -> BvhNode {
        write_references(self.primitives, self.references);
        BvhNode::leaf(extent.bounds.to_aabb(), self.first, self.primitives.len() as u32)
    }
}

/// Leaves nothing in `nodes` but the root's place, and room for all nodes over `count` primitives.
pub(super) fn start(nodes: &mut Vec<BvhNode>, count: usize) {
    nodes.clear();
    // Growing would copy, and hold both copies. Memory that is not reached is never touched.
    nodes.reserve(2 * count);
    nodes.push(BvhNode::leaf(Aabb::EMPTY, 0, 0));
}

/// Builds sub-trees by binning: Wald 2007, §3.
///
/// Nodes are appended depth first, left before right, so a sub-tree's nodes lie together.
#[derive(Debug)]
pub(super) struct SubtreeBuilder<'a> {
    settings: &'a BvhSettings,
    leaf_size: usize,
    bins: Bins,
}

impl<'a> SubtreeBuilder<'a> {
    pub(super) fn new(settings: &'a BvhSettings, leaf_size: usize) -> Self {
        Self {
            settings,
            leaf_size,
            bins: Bins::EMPTY,
        }
    }

    /// Replaces `nodes` by the sub-tree over `span`. Its children's places count from its own root.
    pub(super) fn build(&mut self, span: Span<'_>, extent: &Extent, nodes: &mut Vec<BvhNode>) {
        start(nodes, span.primitives.len());
        self.fill(span, extent, 0, nodes);
    }

    /// Writes the node at `index` and appends what is below.
    fn fill(&mut self, mut span: Span<'_>, extent: &Extent, index: usize, nodes: &mut Vec<BvhNode>) {
        let Some((count, children)) = self.part(&mut span, extent) else {
            nodes[index] = span.into_leaf(extent);
            return;
        };
        let left = nodes.len();
        nodes[index] = BvhNode::inner(extent.bounds.to_aabb(), left as u32);
        nodes.extend([nodes[index]; 2]);
        for (side, child) in span.split_at(count).into_iter().enumerate() {
            self.fill(child, &children[side], left + side, nodes);
        }
    }

    /// Parts the primitives; how many are on the left, and the extents of both sides. `None` for a leaf.
    fn part(&mut self, span: &mut Span<'_>, extent: &Extent) -> Option<(usize, [Extent; 2])> {
        let count = span.primitives.len();
        if count <= self.leaf_size.max(1) {
            return None;
        }
        let projection = Projection::new(extent)?;
        let measure = Measure::new(&extent.bounds);
        if must_halve(span.depth, count) {
            return self.halve(span.primitives, projection.axis(), &measure);
        }
        self.bins.fill(span.primitives, &projection);
        let split = self.bins.cheapest_split(&measure);
        if !measure.split_pays(split.parts, count, self.settings) {
            return None;
        }
        Some(partition(span.primitives, &projection, split.bin))
    }

    /// Parts the primitives into two halves by their centroids along the widest axis.
    fn halve(&self, primitives: &mut [Primitive], axis: usize, measure: &Measure) -> Option<(usize, [Extent; 2])> {
        let middle = sort_into_halves(primitives, axis);
        let (left, right) = primitives.split_at(middle);
        let sides = [left, right];
        let extents = sides.map(Extent::of);
        let parts = [0, 1].map(|side| measure.of(&extents[side].bounds) * sides[side].len() as f32);
        let pays = measure.split_pays(parts[0] + parts[1], primitives.len(), self.settings);
        pays.then_some((middle, extents))
    }
}

/// Parts the primitives in place, those in bins below `bin` to the left, and tracks the extents of both sides: Wald 2007,
/// §3.6.
///
/// Differs: the list holds boxes beside their indices, so that nothing is looked up. One iterator instead of the two
/// of *quicksort*: each primitive changes places with the first on the right and the border moves or not, without a
/// branch that depends on the data.
fn partition(primitives: &mut [Primitive], projection: &Projection, bin: usize) -> (usize, [Extent; 2]) {
    let mut extents = [Extent::EMPTY; 2];
    let mut middle = 0;
    for next in 0..primitives.len() {
        let right = projection.bin(&primitives[next]) >= bin;
        extents[usize::from(right)].grow(&primitives[next]);
        primitives.swap(next, middle);
        middle += usize::from(!right);
    }
    (middle, extents)
}
