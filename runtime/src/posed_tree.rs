use crate::{
    Aabb,
    box_tree::BoxTree,
    build::BvhSettings,
    wide::{WideNode, append_nodes},
};
use std::sync::{
    OnceLock,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// A ray saves about as much in the wide tree as so many triangles take to get there from the binary one: 160 ns a ray through the
/// horse, 350 through ELEPHANT, at 45 and 70 ns a triangle.
const TRIANGLES_PER_RAY: usize = 4;

/// The tree over triangles that are posed anew in each frame: a binary one, and once that pays for the rays of a frame, a wide one
/// of the same boxes. If it paid in the last frame, it is there from the start.
#[derive(Debug, Default)]
pub(crate) struct PosedTree {
    binary: BoxTree,
    wide: OnceLock<Vec<WideNode>>,
    /// That have entered, until they are enough.
    rays: AtomicU32,
}

impl PosedTree {
    /// Builds it over triangles, each named once, with the boxes that `bound` tells. What has an empty box is in no leaf.
    pub(crate) fn rebuild(&mut self, triangles: impl Iterator<Item = u32>, bound: impl Fn(u32) -> Aabb + Sync) {
        let enough = self.enough();
        let were_enough = enough > 0 && *self.rays.get_mut() >= enough;
        let wide = self.wide.take();
        *self.rays.get_mut() = 0;
        self.binary.rebuild(triangles, bound, &BvhSettings::default());
        if were_enough {
            let mut nodes = wide.unwrap_or_default();
            nodes.clear();
            self.binary.collapse(&mut nodes);
            self.wide = OnceLock::from(nodes);
        }
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

    /// The wide tree, for so many rays that enter, if it pays. Not empty.
    #[inline]
    pub(crate) fn wide_for(&self, rays: u32) -> Option<&[WideNode]> {
        let enough = self.enough();
        // All threads write here, so no more than must be.
        if self.rays.load(Relaxed) < enough {
            self.rays.fetch_add(rays, Relaxed);
        }
        if let Some(wide) = self.wide.get() {
            return Some(wide);
        }
        (self.rays.load(Relaxed) >= enough).then(|| {
            &self.wide.get_or_init(|| {
                let mut nodes = Vec::new();
                self.binary.collapse(&mut nodes);
                nodes
            })[..]
        })
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
        let is_wide = |tree: &PosedTree| tree.wide.get().is_some();
        tree.rebuild(0..400, in_a_row);
        assert!(tree.wide_for(64).is_none() && tree.wide_for(35).is_none());
        assert_eq!(tree.wide_for(1).map(|nodes| nodes[0].around()), Some(tree.bounds()));
        tree.rebuild(0..200, in_a_row);
        assert!(is_wide(&tree), "as many rays are expected again");
        assert_eq!(tree.wide_for(49).map(|nodes| nodes[0].around()), Some(tree.bounds()));
        tree.rebuild(0..400, in_a_row);
        assert!(!is_wide(&tree), "49 rays were too few for 200 triangles");
        tree.rebuild(0..0, in_a_row);
        assert_eq!(tree.wide_for(1), Some(&[WideNode::EMPTY][..]));
    }
}
