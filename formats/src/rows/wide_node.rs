use super::NONE;
use bytemuck::{Pod, Zeroable};

/// No path from a root to a leaf has more nodes; traversal stacks have seven places for each.
pub const MAX_WIDE_DEPTH: usize = 32;

/// A node of a wide fuzzy tree: eight children with their boxes, in 136 bytes.
///
/// Boxes of a node without movers are on the lattice of their cluster's [`bounds_local`](super::ClusterRow::bounds_local),
/// whose steps are [`box_steps`](super::box_steps), as those of [`ReferenceBoxRow`](super::ReferenceBoxRow) are: they hold
/// what is below them in the whole pose space; that of a triangle is its fuzzy box. Boxes of a node with movers are on the
/// cluster's [`RestLattice`](super::RestLattice) and hold the rest positions, without morphs, of what is below them; its
/// [`NodeMoverRow`](super::NodeMoverRow)s say how they follow a pose. A box is around those of the child's places where the
/// child is of the same kind.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct WideNodeRow {
    /// Least corners: per axis, per child. The coordinates of empty places are [`u16::MAX`], here and in `max`.
    pub min: [[u16; 8]; 3],
    /// Greatest corners; not below the least.
    pub max: [[u16; 8]; 3],
    /// Packed [`WideChild`]ren. Empty places come last.
    pub children: [u32; 8],
    /// First node-mover row.
    pub mover_first: u32,
    /// Node-mover rows, at most [`MAX_MOVERS`](super::MAX_MOVERS); those of the nodes follow each other.
    pub mover_count: u32,
}

/// What stands in one of a wide node's eight places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WideChild {
    /// Nothing.
    Empty,
    /// A node, by its index from the tree's first node. It stands behind its parent.
    Node(u32),
    /// A leaf of one thing: in a fuzzy tree, a triangle row.
    Leaf(u32),
}

impl WideChild {
    /// Set in the packed form of leaves and of empty places.
    pub const LEAF_BIT: u32 = 1 << 31;
    /// An empty place, packed.
    pub const EMPTY: u32 = NONE;
    /// Largest index that fits: one of a leaf may not look like an empty place.
    pub const MAX_INDEX: u32 = Self::LEAF_BIT - 2;

    /// Packs a child. Indices above [`WideChild::MAX_INDEX`] do not fit and are the caller's fault.
    #[must_use]
    pub fn pack(self) -> u32 {
        match self {
            Self::Empty => Self::EMPTY,
            Self::Node(index) => {
                debug_assert!(index <= Self::MAX_INDEX);
                index
            }
            Self::Leaf(index) => {
                debug_assert!(index <= Self::MAX_INDEX);
                index | Self::LEAF_BIT
            }
        }
    }

    /// Decodes a child.
    #[inline]
    #[must_use]
    pub fn unpack(word: u32) -> Self {
        if word == Self::EMPTY {
            Self::Empty
        } else if word & Self::LEAF_BIT != 0 {
            Self::Leaf(word & !Self::LEAF_BIT)
        } else {
            Self::Node(word)
        }
    }
}

impl WideNodeRow {
    /// A node without children.
    pub const EMPTY: Self = Self {
        min: [[u16::MAX; 8]; 3],
        max: [[u16::MAX; 8]; 3],
        children: [WideChild::EMPTY; 8],
        mover_first: 0,
        mover_count: 0,
    };

    /// What stands in its places, up to the first empty one.
    pub fn children(&self) -> impl Iterator<Item = WideChild> + '_ {
        self.children
            .iter()
            .map(|word| WideChild::unpack(*word))
            .take_while(|child| *child != WideChild::Empty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_are_packed_and_unpacked() {
        for child in [
            WideChild::Empty,
            WideChild::Node(0),
            WideChild::Node(WideChild::MAX_INDEX),
            WideChild::Leaf(0),
            WideChild::Leaf(WideChild::MAX_INDEX),
        ] {
            assert_eq!(WideChild::unpack(child.pack()), child);
        }
        assert_eq!(size_of::<WideNodeRow>(), 136);
    }
}
