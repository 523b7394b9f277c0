use bytemuck::{Pod, Zeroable};
use restpose_formats::geom::Aabb;

/// At most this many inner nodes stand above a leaf of a [`Bvh`]: what traversal keeps room for.
pub const MAX_BVH_DEPTH: usize = 64;

/// A bounding volume hierarchy over boxes.
///
/// The root is `nodes[0]`, siblings are adjacent, children stand behind their parents, at most [`MAX_BVH_DEPTH`] inner
/// nodes stand above a leaf. A node's box is the smallest around what it contains. The leaves' ranges partition
/// `references`, which lists each box once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh {
    /// Nodes; the root first. Empty until built.
    pub nodes: Vec<BvhNode>,
    /// Indices of boxes, by leaf.
    pub references: Vec<u32>,
}

/// A node of a [`Bvh`], half a cache line.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BvhNode {
    min: [f32; 3],
    /// Left child, or first reference.
    first: u32,
    max: [f32; 3],
    /// References of a leaf; 0 for an inner node.
    count: u32,
}

/// What a [`BvhNode`] holds beside its box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhContent {
    /// Two nodes, at `left` and behind it.
    Inner {
        /// The first child.
        left: u32,
    },
    /// A range of references, never empty.
    Leaf {
        /// The first reference.
        first: u32,
        /// How many.
        count: u32,
    },
}

/// Constants of the cost model of a BVH. Only their ratio matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhSettings {
    /// Cost of visiting an inner node, K_Trav. Default 1.
    pub traversal_cost: f64,
    /// Cost of testing one primitive, K_Isec. Default 1.
    pub intersection_cost: f64,
}

impl Default for BvhSettings {
    fn default() -> Self {
        Self {
            traversal_cost: 1.0,
            intersection_cost: 1.0,
        }
    }
}

impl BvhNode {
    /// An inner node over the nodes at `left` and behind it.
    #[must_use]
    pub fn inner(bounds: Aabb, left: u32) -> Self {
        Self {
            min: bounds.min,
            first: left,
            max: bounds.max,
            count: 0,
        }
    }

    /// A leaf with `count` references, at least one, from `first` on.
    #[must_use]
    pub fn leaf(bounds: Aabb, first: u32, count: u32) -> Self {
        Self {
            min: bounds.min,
            first,
            max: bounds.max,
            count,
        }
    }

    /// The box around all that it contains.
    #[inline]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: self.min,
            max: self.max,
        }
    }

    /// What it holds.
    #[inline]
    #[must_use]
    pub fn content(&self) -> BvhContent {
        match self.count {
            0 => BvhContent::Inner { left: self.first },
            count => BvhContent::Leaf {
                first: self.first,
                count,
            },
        }
    }
}

impl Bvh {
    /// Forgets what was built, and keeps its memory.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.references.clear();
    }

    /// The box around everything; empty before anything was built.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, BvhNode::bounds)
    }

    /// The expected cost of a ray that meets the root's box: C_Tree. K_Trav is charged for inner nodes, K_Isec for the
    /// references of leaves.
    ///
    /// A tree whose root has no area is measured by the lengths of its boxes instead, one that is a point by counts.
    ///
    /// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, Eq. 4.1.
    #[must_use]
    pub fn sah_cost(&self, settings: &BvhSettings) -> f64 {
        let measure = |bounds: &Aabb, by_length: bool| {
            if by_length {
                (0..3)
                    .map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]))
                    .sum()
            } else {
                bounds.surface_area()
            }
        };
        let root = self.bounds();
        let by_length = root.surface_area() <= 0.0;
        let whole = measure(&root, by_length);
        let cost = |node: &BvhNode| {
            let chance = if whole > 0.0 {
                measure(&node.bounds(), by_length) / whole
            } else {
                1.0
            };
            chance
                * match node.content() {
                    BvhContent::Inner { .. } => settings.traversal_cost,
                    BvhContent::Leaf { count, .. } => settings.intersection_cost * f64::from(count),
                }
        };
        self.nodes.iter().map(cost).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_those_of_equation_4_1() {
        // Half areas: root 4 · 2 · 1 → 14, left 1 × 2 × 1 → 5, right 2 × 1 × 1 → 5.
        let bounds = |min, max| Aabb { min, max };
        let tree = Bvh {
            nodes: vec![
                BvhNode::inner(bounds([0.0; 3], [4.0, 2.0, 1.0]), 1),
                BvhNode::leaf(bounds([0.0; 3], [1.0, 2.0, 1.0]), 0, 3),
                BvhNode::leaf(bounds([2.0, 0.0, 0.0], [4.0, 1.0, 1.0]), 3, 2),
            ],
            references: vec![0, 1, 2, 3, 4],
        };
        let settings = BvhSettings {
            traversal_cost: 2.0,
            intersection_cost: 3.0,
        };
        let expected = 2.0 + 3.0 * (3.0 * 5.0 + 2.0 * 5.0) / 14.0;
        assert!(
            (tree.sah_cost(&settings) - expected).abs() < 1e-12,
            "rounding of six operations"
        );
        assert_eq!(Bvh::default().sah_cost(&settings), 0.0);
    }

    #[test]
    fn lines_are_measured_by_length_and_points_by_count() {
        let line = |min, max| Aabb {
            min: [min, 0.0, 0.0],
            max: [max, 0.0, 0.0],
        };
        let tree = |whole, left, right| Bvh {
            nodes: vec![
                BvhNode::inner(whole, 1),
                BvhNode::leaf(left, 0, 1),
                BvhNode::leaf(right, 1, 1),
            ],
            references: vec![0, 1],
        };
        let settings = BvhSettings::default();
        let cost = tree(line(0.0, 4.0), line(0.0, 1.0), line(3.0, 4.0)).sah_cost(&settings);
        assert_eq!(cost, 1.0 + 0.25 + 0.25);
        let point = line(7.0, 7.0);
        assert_eq!(tree(point, point, point).sah_cost(&settings), 3.0);
    }

    #[test]
    fn nodes_give_back_what_they_hold() {
        let bounds = Aabb {
            min: [1.0, 2.0, 3.0],
            max: [4.0, 5.0, 6.0],
        };
        let inner = BvhNode::inner(bounds, 9);
        assert_eq!(
            (inner.bounds(), inner.content()),
            (bounds, BvhContent::Inner { left: 9 })
        );
        let leaf = BvhNode::leaf(bounds, 7, 2);
        assert_eq!(leaf.content(), BvhContent::Leaf { first: 7, count: 2 });
        assert_eq!(size_of::<BvhNode>(), 32);
    }
}
