use crate::{
    Aabb,
    box_tree::BoxTree,
    build::{BvhSettings, finite_box},
    wide::{WideNode, refit},
};

/// To enter what stands in a leaf takes as long as eight steps: so leaves have one, where boxes differ at all.
const SETTINGS: BvhSettings = BvhSettings {
    traversal_cost: 1.0,
    intersection_cost: 8.0,
};

/// A tree that is refitted from frame to frame is built anew once rays are expected to meet so many times the nodes that they met
/// when it was built. To build it over 1,000 instances takes as long as 1,000 rays in a crowd take for a tenth more nodes there
/// (235 µs; 22 steps a ray at 10 ns), and few frames of a crowd change it by that.
const STALE: f64 = 1.1;

/// A wide tree in world space over a scene's instances, or an instance's clusters.
#[derive(Debug)]
pub(crate) struct TopLevel {
    builder: BoxTree,
    nodes: Vec<WideNode>,
    bounds: Aabb,
    /// Of how many ids it was built; `None` where some had no box, and so are in no leaf.
    leaves: Option<u32>,
    /// When it was built.
    cost: f64,
}

impl Default for TopLevel {
    fn default() -> Self {
        Self {
            builder: BoxTree::default(),
            nodes: Vec::new(),
            bounds: Aabb::EMPTY,
            leaves: None,
            cost: f64::INFINITY,
        }
    }
}

impl TopLevel {
    /// Builds it over `ids`, each of them named once. What has an empty box is in no leaf.
    pub(crate) fn rebuild(&mut self, ids: impl Iterator<Item = u32>, bound: impl Fn(u32) -> Aabb + Sync) {
        self.builder.rebuild(ids, bound, &SETTINGS);
        self.nodes.clear();
        self.builder.collapse(&mut self.nodes);
        self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
    }

    /// The tree over ids from 0 to `count`: the one that is there with the boxes of now, if that is nearly as good as a new one.
    pub(crate) fn update(&mut self, count: u32, bound: impl Fn(u32) -> Aabb + Sync) {
        let bound = |id| finite_box(&bound(id)).unwrap_or(Aabb::EMPTY);
        if self.leaves == Some(count) {
            refit(&mut self.nodes, bound);
            self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
            if self.expected_nodes() <= STALE * self.cost {
                return;
            }
        }
        self.rebuild(0..count, bound);
        self.leaves = (0..count).all(|id| !bound(id).is_empty()).then_some(count);
        self.cost = self.expected_nodes();
    }

    /// Nodes below the root that a ray which meets the root is expected to meet; NaN where the root has no surface.
    fn expected_nodes(&self) -> f64 {
        let areas = self.nodes.iter().skip(1).map(|node| node.around().surface_area());
        areas.sum::<f64>() / self.bounds.surface_area()
    }

    /// Takes the topology of a tree that was built over the same ids, with the boxes of now.
    ///
    /// The topology of an earlier call is kept: it is that of the same tree.
    pub(crate) fn refit(&mut self, topology: &Self, bound: impl Fn(u32) -> Aabb) {
        if self.nodes.len() != topology.nodes.len() {
            self.nodes.clone_from(&topology.nodes);
        }
        refit(&mut self.nodes, bound);
        self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
    }

    /// The root first; empty until built.
    pub(crate) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// Box around everything; empty where there is nothing.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::rows::WideChild;

    /// Boxes in a row, the one with id `i` at place `at(i)`.
    fn in_a_row(at: impl Fn(u32) -> u32 + Sync) -> impl Fn(u32) -> Aabb + Sync {
        move |id| {
            let x = at(id) as f32;
            Aabb {
                min: [x, 0.0, 0.0],
                max: [x + 0.5, 1.0, 1.0],
            }
        }
    }

    fn children(tree: &TopLevel) -> Vec<[u32; 8]> {
        tree.nodes.iter().map(|node| node.children).collect()
    }

    fn built(count: u32, bound: impl Fn(u32) -> Aabb + Sync) -> TopLevel {
        let mut tree = TopLevel::default();
        tree.rebuild(0..count, bound);
        tree
    }

    /// Ids in leaves with a box that is not empty, in order.
    fn ids(tree: &TopLevel) -> Vec<u32> {
        let places = tree
            .nodes
            .iter()
            .flat_map(|node| (0..8).map(move |place| (node, place)));
        let mut ids: Vec<u32> = places
            .filter(|(node, place)| !node.bounds(*place).is_empty())
            .filter_map(|(node, place)| match WideChild::unpack(node.children[place]) {
                WideChild::Leaf(id) => Some(id),
                _ => None,
            })
            .collect();
        ids.sort_unstable();
        ids
    }

    #[test]
    fn a_tree_that_is_still_good_is_kept_with_the_boxes_of_now() {
        let mut tree = TopLevel::default();
        tree.update(100, in_a_row(|id| 2 * id));
        let before = children(&tree);
        // The same row seen from behind: as good a tree, though not the one that would be built.
        let mirrored = || in_a_row(|id| 2 * (99 - id));
        tree.update(100, mirrored());
        let new = built(100, mirrored());
        assert!(children(&tree) == before && children(&new) != before);
        assert_eq!(tree.bounds(), new.bounds());
        assert_eq!(ids(&tree), (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_shuffled_gets_a_new_tree() {
        let mut tree = TopLevel::default();
        tree.update(101, in_a_row(|id| id));
        let shuffled = || in_a_row(|id| id * 37 % 101);
        tree.update(101, shuffled());
        let new = built(101, shuffled());
        assert!(children(&tree) == children(&new) && tree.bounds() == new.bounds());
    }

    #[test]
    fn more_ids_or_fewer_get_a_new_tree() {
        let mut tree = TopLevel::default();
        for count in [0, 1, 9, 10, 9, 0, 3] {
            tree.update(count, in_a_row(|id| id));
            assert_eq!(ids(&tree), (0..count).collect::<Vec<_>>());
        }
    }

    /// What had no box when the tree was built is in it once it has one; what has none any more is not entered.
    #[test]
    fn boxes_come_and_go() {
        let mut tree = TopLevel::default();
        let without = |absent: &'static [u32]| {
            let bound = in_a_row(|id| id);
            move |id| if absent.contains(&id) { Aabb::EMPTY } else { bound(id) }
        };
        let mut found = Vec::new();
        for absent in [
            &[3, 4][..],
            &[4],
            &[],
            &[7],
            &[0, 7],
            &[],
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
            &[],
        ] {
            tree.update(10, without(absent));
            found.push((0..10).filter(|id| !absent.contains(id)).collect::<Vec<_>>() == ids(&tree));
        }
        assert_eq!(found, [true; 8]);
    }

    /// Boxes without a surface have no cost to compare, and infinite ones are cut off as in a new tree.
    #[test]
    fn boxes_at_the_ends_of_numbers() {
        let mut tree = TopLevel::default();
        for side in [0.0, f32::MIN_POSITIVE, f32::INFINITY, f32::NAN, 1.0] {
            let bound = |id: u32| Aabb {
                min: [id as f32; 3],
                max: [id as f32 + side; 3],
            };
            for _ in 0..2 {
                tree.update(20, bound);
                assert_eq!(ids(&tree), (0..20).collect::<Vec<_>>(), "{side}");
                assert_eq!(tree.bounds(), built(20, bound).bounds(), "{side}");
            }
        }
    }
}
