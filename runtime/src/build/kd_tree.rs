use restpose_formats::geom::Aabb;
use restpose_formats::rows::KdNodeRow;

/// A kd-tree over boxes.
///
/// A node's cell is the tree's bounds, cut by the planes above it; cells are closed, so both children own the plane
/// between them. A box is listed by a child when it has points strictly on that side of the plane within the cell. A box
/// whose part in the cell lies wholly in the plane is listed by exactly one child, the one where it costs less.
///
/// Guarantee: take any point p of any box that is not empty, and descend from the root, at each inner node to the left
/// if p\[axis\] ≤ split and to the right if p\[axis\] ≥ split, hence both ways if they are equal. At least one of the
/// leaves reached lists the box. So a traversal finds every box if it visits both children near the plane: for it, a
/// plane needs a margin above zero. Infinite and NaN sides count as ±`f32::MAX`; no leaf lists an empty box.
///
/// The root is `nodes[0]`, siblings are adjacent, children stand behind their parents, at most
/// [`MAX_KD_DEPTH`](restpose_formats::rows::MAX_KD_DEPTH) inner nodes stand above a leaf. The leaves' reference ranges
/// partition `references`; within a leaf, references ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct KdTree {
    /// Node rows; the root first. Never empty once built.
    pub nodes: Vec<KdNodeRow>,
    /// Indices of boxes, by leaf.
    pub references: Vec<u32>,
    /// The smallest box around all boxes, with finite sides; [`Aabb::EMPTY`] for none.
    pub bounds: Aabb,
}

impl Default for KdTree {
    /// No nodes: to be built into.
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            references: Vec::new(),
            bounds: Aabb::EMPTY,
        }
    }
}
