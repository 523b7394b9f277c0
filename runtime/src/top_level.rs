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

/// A tree that is refitted from frame to frame is built anew once its nodes have, on average, so many times the area that they
/// had when it was built. Over 1,000 instances it is built in 0.2 ms, which 10,000 rays take for a tenth more steps (22 of 10 ns
/// each in a crowd of foxes).
const STALE: f64 = 1.1;

/// A wide tree in world space over a scene's instances, or an instance's clusters.
#[derive(Debug)]
pub(crate) struct TopLevel {
    builder: BoxTree,
    nodes: Vec<WideNode>,
    bounds: Aabb,
    built: Built,
}

/// What an [update](TopLevel::update) is to know of the one that built the tree.
#[derive(Debug, Default)]
struct Built {
    /// Ids are below it.
    count: u32,
    /// Ids that had no box, and so are in no leaf.
    absent: Vec<u32>,
    /// Of nodes behind the root.
    areas: Vec<f64>,
}

impl Default for TopLevel {
    fn default() -> Self {
        Self {
            builder: BoxTree::default(),
            nodes: Vec::new(),
            bounds: Aabb::EMPTY,
            built: Built::default(),
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

    /// The tree over ids below `count`: that of the last call with the boxes of now, as long as it is as good as it was.
    pub(crate) fn update(&mut self, count: u32, bound: impl Fn(u32) -> Aabb + Sync) {
        let bound = |id| finite_box(&bound(id)).unwrap_or(Aabb::EMPTY);
        if self.built.count == count && self.built.absent.iter().all(|id| bound(*id).is_empty()) {
            refit(&mut self.nodes, bound);
            self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
            if self.growth() <= STALE {
                return;
            }
        }
        self.rebuild(0..count, bound);
        self.built.count = count;
        self.built.absent.clear();
        self.built.absent.extend((0..count).filter(|id| bound(*id).is_empty()));
        let nodes = self.nodes.iter().skip(1);
        self.built.areas.clear();
        self.built.areas.extend(nodes.map(|node| node.around().surface_area()));
    }

    /// By how many times the area of nodes but the root has grown since the tree was built. A mean of ratios, not the ratio of
    /// sums: there what is large would hide what becomes of many that are small. Infinite or NaN where there was no area.
    fn growth(&self) -> f64 {
        let now = self.nodes.iter().skip(1).map(|node| node.around().surface_area());
        let ratios = now.zip(&self.built.areas).map(|(now, built)| now / built);
        ratios.sum::<f64>() / self.built.areas.len().max(1) as f64
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

    /// Ids in leaves with a box that is not empty, in order, and that box.
    fn leaves(tree: &TopLevel) -> Vec<(u32, Aabb)> {
        let places = tree
            .nodes
            .iter()
            .flat_map(|node| (0..8).map(move |place| (node, place)));
        let mut leaves: Vec<(u32, Aabb)> = places
            .filter(|(node, place)| !node.bounds(*place).is_empty())
            .filter_map(|(node, place)| match WideChild::unpack(node.children[place]) {
                WideChild::Leaf(id) => Some((id, node.bounds(place))),
                _ => None,
            })
            .collect();
        leaves.sort_unstable_by_key(|(id, _)| *id);
        leaves
    }

    fn ids(tree: &TopLevel) -> Vec<u32> {
        leaves(tree).into_iter().map(|(id, _)| id).collect()
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
        assert_eq!(leaves(&tree), leaves(&new));
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

    /// One that left the others long ago does not hide what they do, nor one that is much larger.
    #[test]
    fn one_that_is_far_away_or_large_hides_nothing() {
        let mut tree = TopLevel::default();
        let far = |at: fn(u32) -> u32| in_a_row(move |id| if id == 0 { 1 << 20 } else { at(id) });
        tree.update(101, far(|id| id));
        let before = children(&tree);
        tree.update(101, far(|id| id));
        assert!(children(&tree) == before);
        tree.update(101, far(|id| id * 37 % 101));
        assert!(children(&tree) == children(&built(101, far(|id| id * 37 % 101))));
        let large = |at: fn(u32) -> u32| {
            let others = in_a_row(at);
            move |id| match id {
                0..9 => Aabb {
                    min: [-1e6; 3],
                    max: [1e6; 3],
                },
                _ => others(id),
            }
        };
        tree.update(102, large(|id| id));
        tree.update(102, large(|id| id * 37 % 102));
        assert!(children(&tree) == children(&built(102, large(|id| id * 37 % 102))));
    }

    /// A crowd that spawns in one place and disperses.
    #[test]
    fn a_tree_that_was_built_of_equal_boxes_does_not_stay() {
        let mut tree = TopLevel::default();
        tree.update(1_000, in_a_row(|_| 7));
        tree.update(1_000, in_a_row(|id| id * 37 % 1_009));
        assert!(children(&tree) == children(&built(1_000, in_a_row(|id| id * 37 % 1_009))));
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

    /// Boxes without an area have no cost to compare, and infinite ones, few or all, are cut off as in a new tree.
    #[test]
    fn boxes_at_the_ends_of_numbers() {
        let mut tree = TopLevel::default();
        for (sides, ids_wide) in [
            ([0.0; 3], 20),
            ([1.0, 0.0, 0.0], 20),
            ([f32::MIN_POSITIVE; 3], 20),
            ([f32::INFINITY; 3], 20),
            ([f32::INFINITY; 3], 1),
            ([f32::NAN; 3], 1),
            ([1.0; 3], 20),
        ] {
            let bound = |id: u32| Aabb {
                min: [id as f32, 0.0, 0.0],
                max: [0, 1, 2].map(|k| {
                    let start = if k == 0 { id as f32 } else { 0.0 };
                    start + if id < ids_wide { sides[k] } else { 1.0 }
                }),
            };
            for _ in 0..2 {
                tree.update(20, bound);
                let new = built(20, bound);
                assert_eq!(leaves(&tree), leaves(&new), "{sides:?} {ids_wide}");
                assert_eq!(tree.bounds(), new.bounds(), "{sides:?} {ids_wide}");
            }
        }
    }
}
