use crate::Aabb;
use bytemuck::{Pod, Zeroable};
use restpose_formats::rows::{WideChild, WideNodeRow};

/// A node of a tree in world space: eight children with their boxes.
///
/// A place whose box is empty (`min > max`) is never entered, whatever stands in it.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct WideNode {
    /// Least corners, then greatest corners: per axis, per child. No side is NaN.
    pub planes: [[[f32; 8]; 3]; 2],
    /// Packed [`WideChild`]ren. A node's index counts in the slice that holds the tree, and is above its parent's.
    pub children: [u32; 8],
}

impl WideNode {
    /// A node without children.
    pub(crate) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]],
        children: [WideChild::EMPTY; 8],
    };

    /// The box of one place.
    #[cfg(test)]
    pub(crate) fn bounds(&self, place: usize) -> Aabb {
        Aabb {
            min: std::array::from_fn(|k| self.planes[0][k][place]),
            max: std::array::from_fn(|k| self.planes[1][k][place]),
        }
    }

    #[inline]
    pub(crate) fn set_bounds(&mut self, place: usize, bounds: &Aabb) {
        for k in 0..3 {
            self.planes[0][k][place] = bounds.min[k];
            self.planes[1][k][place] = bounds.max[k];
        }
    }

    /// The box around all of its places; empty where all of them are.
    #[inline]
    pub(crate) fn around(&self) -> Aabb {
        // Pairs first, so that no lane waits for the one before it.
        let fold = |lanes: &[f32; 8], pick: fn(f32, f32) -> f32| {
            let four: [f32; 4] = std::array::from_fn(|i| pick(lanes[i], lanes[i + 4]));
            pick(pick(four[0], four[2]), pick(four[1], four[3]))
        };
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let greater = |a: f32, b: f32| if a > b { a } else { b };
        Aabb {
            min: std::array::from_fn(|k| fold(&self.planes[0][k], less)),
            max: std::array::from_fn(|k| fold(&self.planes[1][k], greater)),
        }
    }
}

/// Appends a tree of the same topology as `rows`, without boxes, and returns the index of its root; `child` says what
/// stands where the rows have a leaf. Several trees can so be joined to one.
///
/// `rows` are one tree's, the root first; `nodes` must stay below 2³¹ nodes.
pub(crate) fn append_rows(
    nodes: &mut Vec<WideNode>,
    rows: &[WideNodeRow],
    mut child: impl FnMut(u32) -> WideChild,
) -> u32 {
    let root = nodes.len() as u32;
    nodes.extend(rows.iter().map(|row| WideNode {
        children: row.children.map(|word| match WideChild::unpack(word) {
            WideChild::Leaf(index) => child(index).pack(),
            _ => moved(word, root),
        }),
        ..WideNode::EMPTY
    }));
    root
}

/// Appends a tree as it is; where its root is.
pub(crate) fn append_nodes(nodes: &mut Vec<WideNode>, tree: &[WideNode]) -> u32 {
    let root = nodes.len() as u32;
    nodes.extend(tree.iter().map(|node| WideNode {
        children: node.children.map(|word| moved(word, root)),
        ..*node
    }));
    root
}

/// A packed child of a tree whose root has moved from 0 to `root`.
fn moved(word: u32, root: u32) -> u32 {
    match WideChild::unpack(word) {
        WideChild::Node(index) => WideChild::Node(root + index).pack(),
        _ => word,
    }
}
