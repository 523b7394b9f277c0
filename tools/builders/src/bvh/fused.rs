use super::BvhBuilder;
use super::depth_limit::{must_halve, sort_into_halves};
use super::fused_bins::{Bin, BinMap, Border, Side};
use super::measure::Measure;
use super::primitive::{Extent, Primitive, list_boxes, set_len};
use super::subtree::{Span, start};
use restpose_runtime::build::{BinCount, Bvh, BvhNode, BvhSettings, CheckedBoxes};

/// Builds by streamed binning to the letter, on one thread: the pass that parts a node, in place, fills the bins of both
/// children.
///
/// A node has [`bin_count`](Self::bin_count) bins on each axis over the interval of its centroids, however few its
/// primitives. It is parted at the smallest centroid of the bin above the cheapest border by Eq. 4.3, and becomes a leaf
/// where no border is cheaper, or where all centroids coincide.
///
/// Complexity: O(n log n) for boxes whose bins fill evenly, at most O(n) per level of the tree. Memory beside the tree:
/// 32 bytes per box, and the bins of each node that waits for its left sibling, at most 30 KiB for each level of the tree.
///
/// The runtime's [`StreamedBvh`](restpose_runtime::build::StreamedBvh) differs where a choice was beaten; costs of trees are
/// the same within 0.5 %, and builds of 70,000 to 1,000,000 boxes on one thread take longer
///
/// - by 13 to 37 % for bins filled in the parting pass, against passes of their own over the node's primitives;
/// - by 1 to 3 % for parting at the smallest centroid, against asking the map of the bins once more;
/// - by 13 to 17 %, with AVX2 by 30 to 35 %, for bins down to two primitives, against exact sweeps of 8 or fewer;
/// - by 6 to 14 % for bins of all primitives of large nodes, against those of a sample where all are short.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.2, which does not say whence the children's intervals are
/// known before the pass: here each bin has the box around its centroids, not only the smallest.
#[derive(Debug)]
pub struct FusedBvh {
    /// Default [`BinCount::ACCURATE`].
    pub bin_count: BinCount,
    primitives: Vec<Primitive>,
    /// A stack: those of the node in work are last, below them those of the right siblings still to come.
    bins: Vec<Bin>,
}

impl Default for FusedBvh {
    fn default() -> Self {
        Self {
            bin_count: BinCount::ACCURATE,
            primitives: Vec::new(),
            bins: Vec::new(),
        }
    }
}

/// A node whose bins are filled.
#[derive(Clone, Copy, Debug)]
struct Binned {
    extent: Extent,
    /// `None` for nodes without bins: those that cannot be parted, and those that must be halved.
    map: Option<BinMap>,
}

/// What a build works with, and what it fills.
struct Build<'a> {
    settings: &'a BvhSettings,
    bin_count: BinCount,
    bins: &'a mut Vec<Bin>,
    nodes: &'a mut Vec<BvhNode>,
}

impl BvhBuilder for FusedBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        set_len(&mut self.primitives, boxes.len(), Primitive::default());
        set_len(&mut tree.references, boxes.len(), 0);
        let extent = list_boxes(boxes, 0, &mut self.primitives);
        start(&mut tree.nodes, boxes.len());
        self.bins.clear();
        let mut build = Build {
            settings,
            bin_count: self.bin_count,
            bins: &mut self.bins,
            nodes: &mut tree.nodes,
        };
        let root = build.bin(&self.primitives, extent, 0);
        build.fill(Span::root(&mut self.primitives, &mut tree.references), &root, 0);
    }
}

impl Build<'_> {
    /// Puts empty bins for a node on the stack.
    fn room_for(&mut self, side: &Side, depth: usize) -> Binned {
        let Side { extent, count } = *side;
        let has_bins = count > 1 && !must_halve(depth, count);
        let map = has_bins
            .then(|| BinMap::new(&extent, self.bin_count.of(count)))
            .flatten();
        self.bins
            .resize(self.bins.len() + map.as_ref().map_or(0, BinMap::len), Bin::EMPTY);
        Binned { extent, map }
    }

    /// Puts the bins of a node on the stack, filled in a pass of its own.
    fn bin(&mut self, primitives: &[Primitive], extent: Extent, depth: usize) -> Binned {
        let first = self.bins.len();
        let count = primitives.len();
        let node = self.room_for(&Side { extent, count }, depth);
        if let Some(map) = &node.map {
            for primitive in primitives {
                map.add(primitive, &mut self.bins[first..]);
            }
        }
        node
    }

    /// Writes the node at `index`, whose bins are the last, and appends what is below.
    fn fill(&mut self, mut span: Span<'_>, node: &Binned, index: usize) {
        let parted = match &node.map {
            Some(map) => self.part(&mut span, node, map),
            None => self.halve(&mut span, node),
        };
        let Some((count, children)) = parted else {
            self.nodes[index] = span.into_leaf(&node.extent);
            return;
        };
        let left = self.nodes.len();
        self.nodes[index] = BvhNode::inner(node.extent.bounds.to_aabb(), left as u32);
        self.nodes.extend([self.nodes[index]; 2]);
        for (side, child) in span.split_at(count).into_iter().enumerate() {
            self.fill(child, &children[side], left + side);
        }
    }

    /// Parts the primitives at the cheapest border; how many are on the left, and the children. `None` for a leaf. Takes
    /// the node's bins off the stack, and puts the children's on it, the left one's last.
    fn part(&mut self, span: &mut Span<'_>, node: &Binned, map: &BinMap) -> Option<(usize, [Binned; 2])> {
        let first = self.bins.len() - map.len();
        let bins = &self.bins[first..];
        let measure = Measure::new(&node.extent.bounds);
        let border = Border::cheapest(bins, map, &measure)
            .filter(|border| measure.split_pays(border.parts, span.primitives.len(), self.settings));
        let parted = border.map(|border| (border.axis, border.plane(bins, map), border.sides(bins, map)));
        self.bins.truncate(first);
        let (axis, plane, [left, right]) = parted?;
        let right = self.room_for(&right, span.depth + 1);
        let middle = self.bins.len();
        let children = [self.room_for(&left, span.depth + 1), right];
        let (right_bins, left_bins) = self.bins[first..].split_at_mut(middle - first);
        let count = distribute(span.primitives, axis, plane, &children, [left_bins, right_bins]);
        Some((count, children))
    }

    /// Parts the primitives into two halves by their centroids along the widest axis. Puts the children's bins on the stack.
    fn halve(&mut self, span: &mut Span<'_>, node: &Binned) -> Option<(usize, [Binned; 2])> {
        let axis = node.extent.widest_centroid_axis()?;
        let middle = sort_into_halves(span.primitives, axis);
        let (left, right) = span.primitives.split_at(middle);
        let sides = [left, right];
        let extents = sides.map(Extent::of);
        let measure = Measure::new(&node.extent.bounds);
        let parts = [0, 1].map(|side| measure.of(&extents[side].bounds) * sides[side].len() as f32);
        if !measure.split_pays(parts[0] + parts[1], span.primitives.len(), self.settings) {
            return None;
        }
        let right = self.bin(right, extents[1], span.depth + 1);
        let left = self.bin(left, extents[0], span.depth + 1);
        Some((middle, [left, right]))
    }
}

/// Parts the primitives in place, those with centroids below the plane to the left, and bins them for both children; how
/// many are on the left.
fn distribute(
    primitives: &mut [Primitive],
    axis: usize,
    plane: f32,
    children: &[Binned; 2],
    bins: [&mut [Bin]; 2],
) -> usize {
    let mut middle = 0;
    for next in 0..primitives.len() {
        let side = usize::from(primitives[next].bounds().center_of(axis) >= plane);
        if let Some(map) = &children[side].map {
            map.add(&primitives[next], bins[side]);
        }
        primitives.swap(next, middle);
        middle += 1 - side;
    }
    middle
}
