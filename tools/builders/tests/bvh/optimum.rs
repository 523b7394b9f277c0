use super::families::FAMILIES;
use super::tree_sets::{built, children, depths, listed};
use restpose_builders::bvh::{BinnedBvh, SweepBvh};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhSettings, MAX_BVH_DEPTH};

/// Costs of builders are in `f32`, stated to err by 2⁻²⁰ at most. Two of them are compared.
const TOLERANCE: f64 = 1.0 / (1 << 19) as f64;

const BINS: usize = 16;

/// Boxes of one node, with the box around them.
struct Node {
    boxes: Vec<Aabb>,
    bounds: Aabb,
}

impl Node {
    fn new(tree: &Bvh, node: usize, boxes: &[Aabb]) -> Self {
        let boxes = listed(tree, node).into_iter().map(|id| boxes[id as usize]).collect();
        let bounds = tree.nodes[node].bounds();
        Self { boxes, bounds }
    }

    /// SA(part) / SA(node), or the lengths where there is next to no area.
    fn share(&self, part: &Aabb) -> f64 {
        let sides = |b: &Aabb| -> [f64; 3] { std::array::from_fn(|k| f64::from(b.max[k]) - f64::from(b.min[k])) };
        let longest = sides(&self.bounds).into_iter().fold(0.0, f64::max);
        let length = |b: &Aabb| sides(b).iter().sum::<f64>();
        if self.bounds.surface_area() > f64::exp2(-96.0) * longest * longest {
            part.surface_area() / self.bounds.surface_area()
        } else {
            length(part) / length(&self.bounds)
        }
    }

    /// C_Part of boxes parted by where `left` is true; `None` if a side is empty.
    fn cost(&self, settings: &BvhSettings, left: impl Fn(&Aabb) -> bool) -> Option<f64> {
        let (mut counts, mut bounds) = ([0.0; 2], [Aabb::EMPTY; 2]);
        for own in &self.boxes {
            let side = usize::from(!left(own));
            counts[side] += 1.0;
            bounds[side] = bounds[side].union(*own);
        }
        let tests = counts[0] * self.share(&bounds[0]) + counts[1] * self.share(&bounds[1]);
        (counts[0] > 0.0 && counts[1] > 0.0).then_some(settings.traversal_cost + settings.intersection_cost * tests)
    }

    /// Whether it may have been parted into halves to keep the tree within its depth.
    fn is_low(&self, depth: usize) -> bool {
        depth + self.boxes.len().next_power_of_two().ilog2() as usize >= MAX_BVH_DEPTH
    }

    fn leaf_cost(&self, settings: &BvhSettings) -> f64 {
        settings.intersection_cost * self.boxes.len() as f64
    }

    /// The least C_Part over all planes through centroids.
    fn cheapest_plane(&self, settings: &BvhSettings) -> Option<f64> {
        let planes = (0..3).flat_map(|axis| self.boxes.iter().map(move |own| (axis, own.center()[axis])));
        planes
            .filter_map(|(axis, plane)| self.cost(settings, |own| own.center()[axis] < plane))
            .min_by(f64::total_cmp)
    }

    /// The bin of each box; `None` when all centroids coincide.
    fn binning(&self) -> Option<impl Fn(&Aabb) -> usize> {
        let centroids = Aabb::around(self.boxes.iter().map(Aabb::center));
        let length = |k: usize| f64::from(centroids.max[k]) - f64::from(centroids.min[k]);
        let apart = (0..3).filter(|k| centroids.min[*k] < centroids.max[*k]);
        let axis = apart.reduce(|a, b| if length(b) > length(a) { b } else { a })?;
        let [least, greatest] = [centroids.min[axis], centroids.max[axis]].map(f64::from);
        let scale = BINS as f64 * (1.0 - f64::exp2(-50.0)) / (greatest - least);
        Some(move |own: &Aabb| ((f64::from(own.center()[axis]) - least) * scale) as usize)
    }
}

/// Checks a node of `tree` against the least cost of a split that the builder may choose.
fn check_choice(node: &Node, found: Option<f64>, least: Option<f64>, settings: &BvhSettings, label: &str) {
    let leaf = node.leaf_cost(settings);
    let bound = (1.0 + TOLERANCE) * least.map_or(leaf, |least| least.min(leaf));
    assert!(
        found.unwrap_or(leaf) <= bound,
        "{label}: {found:?}, least {least:?}, leaf {leaf}"
    );
}

/// Boxes compared by their bits, in any order.
fn sorted(boxes: &[Aabb]) -> Vec<[u32; 6]> {
    let sides = |b: &Aabb| std::array::from_fn(|k| if k < 3 { b.min[k] } else { b.max[k - 3] }.to_bits());
    let mut all: Vec<_> = boxes.iter().map(sides).collect();
    all.sort_unstable();
    all
}

#[test]
fn sweep_splits_are_the_optimum_over_all_planes() {
    let mut builder = SweepBvh::default();
    let (mut splits, mut leaves) = (0, 0);
    for settings in [1.0, 0.1].map(|traversal_cost| BvhSettings {
        traversal_cost,
        intersection_cost: 1.0,
    }) {
        for (name, family) in FAMILIES {
            for n in [2, 3, 5, 8, 13, 40] {
                for seed in 0..4 {
                    let boxes = family(n, seed);
                    let tree = built(&mut builder, &boxes, &settings);
                    for (index, depth) in depths(&tree).into_iter().enumerate() {
                        let node = Node::new(&tree, index, &boxes);
                        if node.is_low(depth) {
                            continue;
                        }
                        let label = format!("{name}, {n} boxes, seed {seed}, node {index}");
                        let least = node.cheapest_plane(&settings);
                        let Some(children) = children(&tree, index) else {
                            check_choice(&node, None, least, &settings, &label);
                            leaves += usize::from(node.boxes.len() > 1);
                            continue;
                        };
                        let [left, right] = children.map(|child| Node::new(&tree, child, &boxes));
                        let parts = [&left, &right].map(|side| side.boxes.len() as f64 * node.share(&side.bounds));
                        let found = settings.traversal_cost + settings.intersection_cost * (parts[0] + parts[1]);
                        check_choice(&node, Some(found), least, &settings, &label);
                        splits += 1;
                    }
                }
            }
        }
    }
    assert!(
        splits > 5_000 && leaves > 500,
        "only {splits} splits and {leaves} leaves were compared"
    );
}

#[test]
fn binned_splits_are_the_best_of_their_bins() {
    let mut builder = BinnedBvh::default();
    let settings = BvhSettings::default();
    let (mut splits, mut leaves) = (0, 0);
    for (name, family) in FAMILIES {
        for n in [3, 5, 8, 13, 40, 300] {
            for seed in 0..4 {
                let boxes = family(n, seed);
                let tree = built(&mut builder, &boxes, &settings);
                for (index, depth) in depths(&tree).into_iter().enumerate() {
                    let node = Node::new(&tree, index, &boxes);
                    if node.is_low(depth) {
                        continue;
                    }
                    let label = format!("{name}, {n} boxes, seed {seed}, node {index}");
                    let bin = node.binning();
                    let border_cost = |border: usize| {
                        let bin = bin.as_ref()?;
                        node.cost(&settings, |own| bin(own) < border)
                    };
                    let least = (1..BINS).filter_map(border_cost).min_by(f64::total_cmp);
                    let Some([left, right]) = children(&tree, index) else {
                        if node.boxes.len() > builder.leaf_size {
                            check_choice(&node, None, least, &settings, &label);
                            leaves += 1;
                        }
                        continue;
                    };
                    assert!(node.boxes.len() > builder.leaf_size, "{label}");
                    let bin = bin.as_ref().unwrap();
                    let [left, right] = [left, right].map(|child| Node::new(&tree, child, &boxes));
                    let border = right.boxes.iter().map(bin).min().unwrap();
                    assert!(left.boxes.iter().all(|own| bin(own) < border), "{label}");
                    let below: Vec<_> = node.boxes.iter().copied().filter(|own| bin(own) < border).collect();
                    assert_eq!(sorted(&left.boxes), sorted(&below), "{label}");
                    check_choice(&node, border_cost(border), least, &settings, &label);
                    splits += 1;
                }
            }
        }
    }
    assert!(
        splits > 5_000 && leaves > 200,
        "only {splits} splits and {leaves} leaves were compared"
    );
}
