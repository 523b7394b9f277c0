use bytemuck::{Pod, Zeroable};

/// No path from a root to a leaf has more inner nodes; traversal stacks have this many places.
pub const MAX_KD_DEPTH: usize = 62;

/// A kd-tree node in eight bytes.
///
/// ```text
/// word 0   inner:  [31..2] index of the left child from the tree's first node   [1..0] axis 0, 1, 2
///          leaf:   [31..2] number of references                                 [1..0] 3
/// word 1   inner:  split position, f32
///          leaf:   first reference, from the tree's first reference
/// ```
/// The right child follows the left one; both stand behind their parent.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct KdNodeRow {
    word0: u32,
    word1: u32,
}

/// A kd-tree node, decoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KdNode {
    /// Splits its cell by the plane `x[axis] = split`.
    Inner {
        /// 0, 1 or 2.
        axis: usize,
        /// Plane position in the tree's space.
        split: f32,
        /// Index of the child below the plane; the one above follows.
        left: u32,
    },
    /// Lists the primitives that overlap its cell.
    Leaf {
        /// First reference.
        first: u32,
        /// References.
        count: u32,
    },
}

impl KdNodeRow {
    /// Largest left-child index or reference count that fits.
    pub const MAX_INDEX: u32 = u32::MAX >> 2;

    /// Packs a node. Indices and counts above [`KdNodeRow::MAX_INDEX`] do not fit and are the caller's fault.
    #[must_use]
    pub fn pack(node: KdNode) -> Self {
        match node {
            KdNode::Inner { axis, split, left } => {
                debug_assert!(axis < 3 && left <= Self::MAX_INDEX);
                Self {
                    word0: left << 2 | axis as u32,
                    word1: split.to_bits(),
                }
            }
            KdNode::Leaf { first, count } => {
                debug_assert!(count <= Self::MAX_INDEX);
                Self {
                    word0: count << 2 | 3,
                    word1: first,
                }
            }
        }
    }

    /// Decodes the node.
    #[inline]
    #[must_use]
    pub fn unpack(self) -> KdNode {
        let axis = (self.word0 & 3) as usize;
        if axis == 3 {
            KdNode::Leaf {
                first: self.word1,
                count: self.word0 >> 2,
            }
        } else {
            KdNode::Inner {
                axis,
                split: f32::from_bits(self.word1),
                left: self.word0 >> 2,
            }
        }
    }
}
