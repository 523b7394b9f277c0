use super::{
    scenes::Triangle,
    traversal::{Counts, Traveller, TreeHit},
    traversal_bvh, traversal_kd,
};
use restpose_formats::rows::KdNode;
use restpose_runtime::{
    Aabb, Ray,
    build::{Bvh, BvhContent, BvhFault, BvhSettings, KdFault, KdSettings, KdTree, sah_cost},
};

/// What a builder made.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Bvh(Bvh),
    Kd(KdTree),
}

/// Why a tree is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeFault {
    /// A hierarchy's.
    #[error(transparent)]
    Bvh(#[from] BvhFault),
    /// A kd-tree's.
    #[error(transparent)]
    Kd(#[from] KdFault),
}

/// Kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TreeKind {
    Bvh,
    Kd,
}

impl TreeKind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Bvh => "bvh",
            Self::Kd => "kd",
        }
    }
}

/// How large a tree is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TreeSize {
    pub nodes: usize,
    pub references: usize,
    /// Inner nodes above the deepest leaf.
    pub depth: usize,
    /// Nodes and references.
    pub bytes: usize,
}

impl Tree {
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), TreeFault> {
        match self {
            Self::Bvh(tree) => Ok(tree.validate(boxes)?),
            Self::Kd(tree) => Ok(tree.validate(boxes)?),
        }
    }

    /// Eq. 4.1 with the default constants of its kind.
    pub fn sah_cost(&self) -> f64 {
        match self {
            Self::Bvh(tree) => tree.sah_cost(&BvhSettings::default()),
            Self::Kd(tree) => sah_cost(&tree.nodes, &tree.bounds, &KdSettings::default()),
        }
    }

    /// Of a tree that is valid.
    pub fn size(&self) -> TreeSize {
        match self {
            Self::Bvh(tree) => TreeSize {
                nodes: tree.nodes.len(),
                references: tree.references.len(),
                depth: depth(tree.nodes.len(), |node| match tree.nodes[node].content() {
                    BvhContent::Inner { left } => Some(left as usize),
                    BvhContent::Leaf { .. } => None,
                }),
                bytes: size_of_val(&tree.nodes[..]) + size_of_val(&tree.references[..]),
            },
            Self::Kd(tree) => TreeSize {
                nodes: tree.nodes.len(),
                references: tree.references.len(),
                depth: depth(tree.nodes.len(), |node| match tree.nodes[node].unpack() {
                    KdNode::Inner { left, .. } => Some(left as usize),
                    KdNode::Leaf { .. } => None,
                }),
                bytes: size_of_val(&tree.nodes[..]) + size_of_val(&tree.references[..]),
            },
        }
    }

    /// The closest hit with a valid tree over the boxes of `triangles`, and what it cost.
    #[inline]
    pub fn closest_hit(&self, ray: &Ray, triangles: &[Triangle]) -> (Option<TreeHit>, Counts) {
        let bounds = match self {
            Self::Bvh(tree) => tree.bounds(),
            Self::Kd(tree) => tree.bounds,
        };
        let Some(mut traveller) = Traveller::new(ray, triangles, &bounds) else {
            return (None, Counts::default());
        };
        let start = ray.t_min.next_down();
        match self {
            Self::Bvh(tree) => traversal_bvh::trace(tree, start, &mut traveller),
            Self::Kd(tree) => traversal_kd::trace(tree, start, &mut traveller),
        }
        (traveller.best, traveller.counts)
    }
}

/// Children stand behind their parents: one pass suffices.
fn depth(nodes: usize, left: impl Fn(usize) -> Option<usize>) -> usize {
    let mut above = vec![0u8; nodes];
    let mut deepest = 0;
    for node in 0..nodes {
        deepest = deepest.max(above[node]);
        if let Some(left) = left(node) {
            above[left] = above[node] + 1;
            above[left + 1] = above[node] + 1;
        }
    }
    usize::from(deepest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builders::{
        rays::{primary_rays, random_rays},
        scenes::{Generated, GeneratedKind, boxes},
        traversal::brute_force,
    };
    use restpose_runtime::build::{BvhNode, KdBuilder};

    /// Splits at the median of the widest axis down to one box a leaf: no builder's own, so that this test depends on none.
    fn median_bvh(boxes: &[Aabb]) -> Bvh {
        let around = |ids: &[u32]| ids.iter().fold(Aabb::EMPTY, |all, id| all.union(boxes[*id as usize]));
        let mut tree = Bvh {
            nodes: vec![BvhNode::leaf(Aabb::EMPTY, 0, 1)],
            references: (0..boxes.len() as u32).collect(),
        };
        let mut open = vec![(0, 0..boxes.len())];
        while let Some((node, range)) = open.pop() {
            let ids = &mut tree.references[range.clone()];
            let bounds = around(ids);
            if ids.len() == 1 {
                tree.nodes[node] = BvhNode::leaf(bounds, range.start as u32, 1);
                continue;
            }
            let axis = (0..3).max_by(|a, b| {
                let side = |k: usize| bounds.max[k] - bounds.min[k];
                side(*a).total_cmp(&side(*b))
            });
            let axis = axis.unwrap();
            let middle = ids.len() / 2;
            ids.select_nth_unstable_by(middle, |a, b| {
                let center = |id: &u32| boxes[*id as usize].center()[axis];
                center(a).total_cmp(&center(b))
            });
            let left = tree.nodes.len();
            tree.nodes[node] = BvhNode::inner(bounds, left as u32);
            tree.nodes.extend([BvhNode::leaf(Aabb::EMPTY, 0, 1); 2]);
            open.push((left, range.start..range.start + middle));
            open.push((left + 1, range.start + middle..range.end));
        }
        tree
    }

    fn trees(triangles: &[Triangle]) -> [Tree; 2] {
        let boxes = boxes(triangles);
        let mut kd = KdTree::default();
        KdBuilder::new().build(&boxes, &KdSettings::default(), &mut kd);
        let trees = [Tree::Bvh(median_bvh(&boxes)), Tree::Kd(kd)];
        for tree in &trees {
            tree.validate(&boxes).unwrap();
        }
        trees
    }

    #[test]
    fn both_traversals_find_what_brute_force_finds() {
        for kind in GeneratedKind::ALL {
            for count in [1, 7, 3000] {
                let scene = Generated { kind, triangles: count };
                let triangles = scene.triangles(4);
                let mut rays = primary_rays(&triangles, 40);
                rays.extend(random_rays(&triangles, 1500, 5));
                // At a corner, and in the planes of boxes.
                for corners in triangles.iter().step_by(1 + count / 300) {
                    let away = corners[0].map(|x| x + 0.25);
                    rays.push(Ray::new(away, std::array::from_fn(|k| corners[1][k] - away[k])));
                    let mut above = corners[2];
                    above[1] += 3.0;
                    rays.push(Ray::new(above, [0.0, -1.0, -0.0]));
                }
                let mut hits = 0;
                for tree in trees(&triangles) {
                    for ray in &rays {
                        let expected = brute_force(ray, &triangles);
                        let (found, counts) = tree.closest_hit(ray, &triangles);
                        assert_eq!(found, expected, "{scene}: {ray:?}");
                        assert!(found.is_none() || counts.tests > 0);
                        hits += usize::from(found.is_some());
                    }
                }
                assert!(
                    count < 100 || hits > 1000,
                    "rays that hit nothing prove nothing: {hits}"
                );
            }
        }
    }

    #[test]
    fn sizes_are_counted() {
        let triangles = Generated {
            kind: GeneratedKind::Regular,
            triangles: 64,
        }
        .triangles(1);
        let [bvh, kd] = trees(&triangles);
        let size = bvh.size();
        assert_eq!((size.nodes, size.references, size.depth), (127, 64, 6));
        assert_eq!(size.bytes, 127 * 32 + 64 * 4);
        let size = kd.size();
        assert!(
            size.references >= 64 && size.nodes % 2 == 1 && (6..64).contains(&size.depth),
            "{size:?}"
        );
        assert_eq!(size.bytes, size.nodes * 8 + size.references * 4);
    }
}
