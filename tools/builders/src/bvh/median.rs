use super::BvhBuilder;
use super::depth_limit::{must_halve, sort_into_halves};
use super::lane_box::LaneBox;
use super::primitive::{Extent, Primitive, list_boxes, set_len};
use super::subtree::{DEFAULT_LEAF_SIZE, Span, start};
use restpose_runtime::build::{Bvh, BvhNode, BvhSettings, CheckedBoxes};

/// Builds by spatial medians, on one thread and in place: the fastest to build and without a cost model.
///
/// A node's voxel, that of the root being the box around everything, is halved across its longest side; centroids below
/// the plane go left. Children get the halves of the voxel, whatever their boxes, which are made when both sub-trees
/// are done. A half without centroids makes no node. A node becomes a leaf at [`leaf_size`](Self::leaf_size)
/// primitives, or where all centroids coincide.
///
/// Complexity: at most O(n) per level of the tree. Memory beside the tree: 32 bytes per box. Settings are not used.
///
/// Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §2.3, after Wächter and Keller 2006.
#[derive(Debug)]
pub struct MedianBvh {
    /// Nodes with so many primitives or fewer become leaves, 0 counting as 1. Default [`DEFAULT_LEAF_SIZE`].
    pub leaf_size: usize,
    primitives: Vec<Primitive>,
}

impl Default for MedianBvh {
    fn default() -> Self {
        Self {
            leaf_size: DEFAULT_LEAF_SIZE,
            primitives: Vec::new(),
        }
    }
}

impl BvhBuilder for MedianBvh {
    fn build(&mut self, boxes: CheckedBoxes<'_>, _: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        set_len(&mut self.primitives, boxes.len(), Primitive::default());
        set_len(&mut tree.references, boxes.len(), 0);
        let extent = list_boxes(boxes, 0, &mut self.primitives);
        // Halves of the smallest numbers round: a centroid may lie beside its box.
        let voxel = Voxel(extent.bounds.union(&extent.centroids));
        start(&mut tree.nodes, boxes.len());
        let span = Span::root(&mut self.primitives, &mut tree.references);
        fill(span, voxel, self.leaf_size.max(1), 0, &mut tree.nodes);
    }
}

/// Writes the node at `index`, appends what is below, and returns its box.
fn fill(mut span: Span<'_>, voxel: Voxel, leaf_size: usize, index: usize, nodes: &mut Vec<BvhNode>) -> LaneBox {
    let Some((count, voxels)) = part(&mut span, voxel, leaf_size) else {
        let extent = Extent::of(span.primitives);
        nodes[index] = span.into_leaf(&extent);
        return extent.bounds;
    };
    let left = nodes.len();
    nodes.extend([nodes[index]; 2]);
    let [lower, upper] = span.split_at(count);
    let bounds = fill(lower, voxels[0], leaf_size, left, nodes);
    let bounds = bounds.union(&fill(upper, voxels[1], leaf_size, left + 1, nodes));
    nodes[index] = BvhNode::inner(bounds.to_aabb(), left as u32);
    bounds
}

/// Parts the primitives; how many are on the left, and the voxels of both sides. `None` for a leaf.
fn part(span: &mut Span<'_>, mut voxel: Voxel, leaf_size: usize) -> Option<(usize, [Voxel; 2])> {
    let count = span.primitives.len();
    if count <= leaf_size {
        return None;
    }
    if must_halve(span.depth, count) {
        let middle = sort_into_halves(span.primitives, voxel.0.longest_axis());
        return Some((middle, [voxel; 2]));
    }
    let axis = voxel.0.longest_axis();
    let mut plane = voxel.middle(axis);
    let mut left = partition(span.primitives, axis, plane);
    if left != 0 && left != count {
        return Some((left, voxel.halves(axis, plane)));
    }
    let (axis, again) = voxel.skip_empty_halves(&Extent::of(span.primitives).centroids)?;
    plane = again;
    left = partition(span.primitives, axis, plane);
    Some((left, voxel.halves(axis, plane)))
}

/// Parts the primitives in place, those with centroids below the plane to the left; how many these are.
fn partition(primitives: &mut [Primitive], axis: usize, plane: f32) -> usize {
    let mut middle = 0;
    for next in 0..primitives.len() {
        let left = primitives[next].bounds().center_of(axis) < plane;
        primitives.swap(next, middle);
        middle += usize::from(left);
    }
    middle
}

/// Where centroids may lie. Fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
struct Voxel(LaneBox);

impl Voxel {
    /// The plane across `axis`. In a voxel that has a length there, above its lower side and at most at its upper one.
    fn middle(&self, axis: usize) -> f32 {
        let [lower, upper] = self.0.sides(axis);
        let middle = (0.5 * (f64::from(lower) + f64::from(upper))) as f32;
        if middle > lower { middle } else { lower.next_up() }
    }

    fn halves(&self, axis: usize, plane: f32) -> [Self; 2] {
        let (mut lower, mut upper) = (*self, *self);
        lower.set_upper(axis, plane);
        upper.set_lower(axis, plane);
        [lower, upper]
    }

    /// Halves on while one half is empty of centroids, of which `centroids` is the box; the axis and plane that part them.
    /// `None` where they coincide.
    ///
    /// On an axis on which all coincide halving would go on for ever: the voxel is shrunk to their coordinate. On any other
    /// the voxel loses one side or the other to the plane until that lies between centroids.
    fn skip_empty_halves(&mut self, centroids: &LaneBox) -> Option<(usize, f32)> {
        for axis in 0..3 {
            let [least, greatest] = centroids.sides(axis);
            if least == greatest {
                self.set_lower(axis, least);
                self.set_upper(axis, least);
            }
        }
        loop {
            let axis = self.0.longest_axis();
            let [least, greatest] = centroids.sides(axis);
            if least == greatest {
                return None;
            }
            let plane = self.middle(axis);
            if greatest < plane {
                self.set_upper(axis, plane);
            } else if least >= plane {
                self.set_lower(axis, plane);
            } else {
                return Some((axis, plane));
            }
        }
    }

    fn set_lower(&mut self, axis: usize, side: f32) {
        self.0.lower.as_mut_array()[axis] = side;
    }

    fn set_upper(&mut self, axis: usize, side: f32) {
        self.0.upper.as_mut_array()[axis] = side;
    }
}
