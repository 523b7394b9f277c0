use crate::{
    Aabb,
    box_tree::BoxTree,
    build::BvhSettings,
    wide::{WideNode, append_nodes},
};
use std::sync::{
    Mutex, OnceLock, PoisonError,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

/// A ray saves about as much in the wide tree as so many triangles take to get there from the binary one: 160 ns a ray through the
/// horse, 350 through ELEPHANT, at 45 and 70 ns a triangle.
const TRIANGLES_PER_RAY: usize = 4;

/// The tree over triangles that are posed anew in each frame: a binary one, and once that pays for the rays of a frame, a wide one
/// of the same boxes. If it paid in the last frame, it is there from the start.
///
/// No ray waits for it: while one thread makes it, which may take tasks of the others, these go through the binary tree.
#[derive(Debug, Default)]
pub(crate) struct PosedTree {
    binary: BoxTree,
    wide: OnceLock<Vec<WideNode>>,
    is_claimed: AtomicBool,
    /// The memory of an earlier wide tree.
    spare: Mutex<Vec<WideNode>>,
    /// That have entered, until they are enough.
    rays: AtomicU32,
}

impl PosedTree {
    /// Builds it over triangles, each named once, with the boxes that `bound` tells. What has an empty box is in no leaf.
    pub(crate) fn rebuild(&mut self, triangles: impl Iterator<Item = u32>, bound: impl Fn(u32) -> Aabb + Sync) {
        let enough = self.enough();
        let were_enough = enough > 0 && *self.rays.get_mut() >= enough;
        if let Some(nodes) = self.wide.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = nodes;
        }
        (*self.rays.get_mut(), *self.is_claimed.get_mut()) = (0, false);
        self.binary.rebuild(triangles, bound, &BvhSettings::default());
        if were_enough {
            self.make_wide();
        }
    }

    fn make_wide(&self) {
        if self.is_claimed.swap(true, Relaxed) {
            return;
        }
        let mut nodes = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
        nodes.clear();
        self.binary.collapse(&mut nodes);
        // Nobody else has claimed it.
        let _ = self.wide.set(nodes);
    }

    fn enough(&self) -> u32 {
        (self.binary.len() / TRIANGLES_PER_RAY) as u32
    }

    /// Box around all of them; empty for none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.binary.bounds()
    }

    /// The binary tree.
    pub(crate) fn binary(&self) -> &BoxTree {
        &self.binary
    }

    /// Counts rays that enter.
    #[inline]
    pub(crate) fn count(&self, rays: u32) {
        // All threads write here, so no more than must be.
        if self.rays.load(Relaxed) < self.enough() {
            self.rays.fetch_add(rays, Relaxed);
        }
    }

    /// The wide tree, if it pays and is there. Not empty.
    #[inline]
    pub(crate) fn wide(&self) -> Option<&[WideNode]> {
        if self.wide.get().is_none() && self.rays.load(Relaxed) >= self.enough() {
            self.make_wide();
        }
        self.wide.get().map(Vec::as_slice)
    }

    /// Appends the wide tree; where its root is.
    pub(crate) fn append(&self, nodes: &mut Vec<WideNode>) -> u32 {
        match self.wide.get() {
            Some(wide) => append_nodes(nodes, wide),
            None => self.binary.collapse(nodes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_a_row(triangle: u32) -> Aabb {
        let x = triangle as f32;
        Aabb {
            min: [x, 0.0, 0.0],
            max: [x + 0.5, 1.0, 1.0],
        }
    }

    #[test]
    fn a_wide_tree_is_made_once_it_pays_and_then_with_the_binary_one() {
        let mut tree = PosedTree::default();
        let wide_for = |tree: &PosedTree, rays: u32| {
            tree.count(rays);
            tree.wide().map(|nodes| nodes[0].around())
        };
        tree.rebuild(0..400, in_a_row);
        assert!(wide_for(&tree, 64).is_none() && wide_for(&tree, 35).is_none());
        assert_eq!(wide_for(&tree, 1), Some(tree.bounds()));
        tree.rebuild(0..200, in_a_row);
        assert_eq!(
            wide_for(&tree, 49),
            Some(tree.bounds()),
            "as many rays are expected again"
        );
        tree.rebuild(0..400, in_a_row);
        assert!(tree.wide().is_none(), "49 rays were too few for 200 triangles");
        tree.rebuild(0..0, in_a_row);
        assert_eq!(tree.wide(), Some(&[WideNode::EMPTY][..]));
    }
}
