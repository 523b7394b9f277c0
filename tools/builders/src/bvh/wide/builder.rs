use super::{WideBvh, collapse::collapse};
use crate::bvh::{BvhBuilder, SweepBvh};
use restpose_formats::{geom::Aabb, rows::MAX_WIDE_DEPTH};
use restpose_runtime::build::{Bvh, BvhContent, BvhNode, BvhSettings, CheckedBoxes};

/// Splits always pay: leaves hold what has one centroid, no more.
const TO_THE_END: BvhSettings = BvhSettings {
    traversal_cost: -1.0,
    intersection_cost: 0.0,
};

/// Builds wide hierarchies: an exact sweep parts the boxes down to single ones, then the nodes are kept that make the
/// cheapest wide hierarchy. Boxes with one centroid are parted into halves by their sizes.
///
/// Guarantee: as of [`SweepBvh`]; [`WideBvh`] says what the hierarchy is. Ends on any boxes.
///
/// Complexity: that of [`SweepBvh`], and O(n). Memory beside the tree: that of the sweep, and 320 bytes per box.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.1.2; Ylitie, Karras, Laine, *Efficient Incoherent Ray
/// Traversal on GPUs Through Compressed Wide BVHs*, 2017: the conversion of a binary hierarchy.
#[derive(Debug, Default)]
pub struct WideBuilder {
    sweep: SweepBvh,
    tree: Bvh,
}

/// More boxes than a [`WideBvh`] can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{count} boxes; expected at most {}; split the geometry", WideBvh::MAX_COUNT)]
pub struct TooManyBoxes {
    /// Boxes given.
    pub count: usize,
}

impl WideBuilder {
    /// Replaces `wide` by the hierarchy over `boxes`.
    ///
    /// # Errors
    /// [`TooManyBoxes`], before any work.
    pub fn build(&mut self, boxes: CheckedBoxes<'_>, wide: &mut WideBvh) -> Result<(), TooManyBoxes> {
        self.build_within(MAX_WIDE_DEPTH, boxes, wide)
    }

    fn build_within(
        &mut self,
        most_depth: usize,
        boxes: CheckedBoxes<'_>,
        wide: &mut WideBvh,
    ) -> Result<(), TooManyBoxes> {
        let count = boxes.get().len();
        if count > WideBvh::MAX_COUNT {
            return Err(TooManyBoxes { count });
        }
        self.sweep.build(boxes, &TO_THE_END, &mut self.tree);
        part_leaves(&mut self.tree, boxes.get());
        collapse(&self.tree, boxes.get(), most_depth, wide);
        Ok(())
    }
}

/// Parts leaves with several boxes into halves, the smaller boxes on the left, down to single ones.
fn part_leaves(tree: &mut Bvh, boxes: &[Aabb]) {
    let mut next = 0;
    // What is appended is met later.
    while let Some(node) = tree.nodes.get(next) {
        let at = next;
        next += 1;
        let BvhContent::Leaf { first, count } = node.content() else {
            continue;
        };
        if count == 1 {
            continue;
        }
        let whole = node.bounds();
        let ids = &mut tree.references[first as usize..][..count as usize];
        let size = |id: &u32| boxes[*id as usize].surface_area();
        ids.sort_unstable_by(|a, b| size(a).total_cmp(&size(b)).then(a.cmp(b)));
        let half = count / 2;
        let around = |ids: &[u32]| {
            ids.iter()
                .fold(Aabb::EMPTY, |bounds, id| bounds.union(boxes[*id as usize]))
        };
        let (smaller, larger) = ids.split_at(half as usize);
        let halves = [
            BvhNode::leaf(around(smaller), first, half),
            BvhNode::leaf(around(larger), first + half, count - half),
        ];
        tree.nodes[at] = BvhNode::inner(whole, tree.nodes.len() as u32);
        tree.nodes.extend(halves);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::wide::plan::Plan;

    fn random_boxes(count: usize, seed: u64) -> Vec<Aabb> {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut boxes = Vec::new();
        for _ in 0..count {
            let mut point = || [0; 3].map(|_| random.f32() * random.f32());
            boxes.push(Aabb::around([point(), point()]));
        }
        boxes
    }

    /// The least sum of shares over every choice of nodes that are kept.
    fn exhaustive(tree: &Bvh) -> f64 {
        let inner: Vec<usize> = (1..tree.nodes.len())
            .filter(|at| matches!(tree.nodes[*at].content(), BvhContent::Inner { .. }))
            .collect();
        let whole = tree.bounds().surface_area();
        let mut least = f64::INFINITY;
        for chosen in 0..1u32 << inner.len() {
            let kept = |node: usize| {
                inner
                    .iter()
                    .position(|at| *at == node)
                    .map(|bit| chosen >> bit & 1 == 1)
            };
            // Children of each node that is not dissolved, behind which all of its children stand.
            let mut children = vec![0; tree.nodes.len()];
            let mut above = vec![0; tree.nodes.len()];
            let mut cost = 1.0;
            for (at, node) in tree.nodes.iter().enumerate() {
                let BvhContent::Inner { left } = node.content() else {
                    continue;
                };
                let own = if at == 0 || kept(at) == Some(true) {
                    at
                } else {
                    above[at]
                };
                for child in [left as usize, left as usize + 1] {
                    above[child] = own;
                    match kept(child) {
                        Some(false) => {}
                        Some(true) => {
                            children[own] += 1;
                            cost += tree.nodes[child].bounds().surface_area() / whole;
                        }
                        None => children[own] += 1,
                    }
                }
            }
            if children.iter().all(|count| *count <= 8) {
                least = f64::min(least, cost);
            }
        }
        least
    }

    #[test]
    fn the_nodes_that_are_kept_are_the_best_choice() {
        let mut several = 0;
        for (count, seed) in (2..18).flat_map(|count| (0..6).map(move |seed| (count, seed))) {
            let boxes = random_boxes(count, seed);
            let mut builder = WideBuilder::default();
            let mut wide = WideBvh::default();
            builder.build(CheckedBoxes::new(&boxes).unwrap(), &mut wide).unwrap();
            let plan = Plan::new(&builder.tree);
            let (mut open, mut kept, mut found) = (vec![0], 0, 0.0);
            while let Some(node) = open.pop() {
                if let BvhContent::Inner { .. } = builder.tree.nodes[node as usize].content() {
                    kept += 1;
                    found += builder.tree.nodes[node as usize].bounds().surface_area() / wide.bounds.surface_area();
                    plan.children(&builder.tree, node, &mut open);
                }
            }
            let expected = exhaustive(&builder.tree);
            assert!(
                (found - expected).abs() < 1e-12,
                "{count} boxes, seed {seed}: {found}, expected {expected}, but for rounding"
            );
            assert_eq!(kept, wide.nodes.len());
            several += u32::from(kept > 2);
        }
        assert!(several > 20, "{several}");
    }

    #[test]
    fn a_depth_that_binds_is_kept() {
        for (count, most_depth) in [
            (8, 1),
            (9, 2),
            (64, 2),
            (65, 3),
            (512, 3),
            (3_000, 4),
            (3_000, 5),
            (3_000, 32),
        ] {
            let boxes = random_boxes(count, 3);
            let mut wide = WideBvh::default();
            let checked = CheckedBoxes::new(&boxes).unwrap();
            WideBuilder::default()
                .build_within(most_depth, checked, &mut wide)
                .unwrap();
            assert_eq!(wide.validate(&boxes), Ok(()), "{count} boxes");
            assert!(wide.depth() <= most_depth, "{count} boxes: {}", wide.depth());
        }
    }

    #[test]
    fn boxes_with_one_centroid_are_parted_by_size() {
        let boxes: Vec<Aabb> = [5, 1, 4, 2, 3]
            .map(|size: u8| Aabb {
                min: [-f32::from(size); 3],
                max: [f32::from(size); 3],
            })
            .to_vec();
        let mut tree = Bvh::default();
        SweepBvh::default().build(CheckedBoxes::new(&boxes).unwrap(), &TO_THE_END, &mut tree);
        assert_eq!(tree.nodes.len(), 1);
        part_leaves(&mut tree, &boxes);
        assert_eq!(tree.validate(&boxes), Ok(()));
        assert_eq!((tree.nodes.len(), &tree.references[..]), (9, &[1, 3, 4, 2, 0][..]));
    }
}
