use super::builders::fast_fused;
use super::families::FAMILIES;
use super::tree_sets::{built, children, depths, listed};
use restpose_builders::bvh::{BinnedBvh, BvhBuilder, FusedBvh, SweepBvh};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{BinCount, Bvh, BvhSettings, MAX_BVH_DEPTH};

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

    fn centroids(&self) -> Aabb {
        Aabb::around(self.boxes.iter().map(Aabb::center))
    }

    /// The bins of [`BinnedBvh`]: along the widest axis, none when all centroids coincide.
    fn bins_of_binned(&self) -> Vec<Binning> {
        let centroids = self.centroids();
        let length = |k: usize| f64::from(centroids.max[k]) - f64::from(centroids.min[k]);
        let apart = (0..3).filter(|k| centroids.min[*k] < centroids.max[*k]);
        let widest = apart.reduce(|a, b| if length(b) > length(a) { b } else { a });
        let binning = |axis: usize| {
            let least = f64::from(centroids.min[axis]);
            let scale = BINS as f64 * (1.0 - f64::exp2(-50.0)) / length(axis);
            let bin = Box::new(move |own: &Aabb| ((f64::from(own.center()[axis]) - least) * scale) as usize);
            Binning { count: BINS, bin }
        };
        widest.map(binning).into_iter().collect()
    }

    /// The bins of [`FusedBvh`]: along each axis as many as the dissertation has.
    fn bins_of_fused(&self, bin_count: BinCount) -> Vec<Binning> {
        let centroids = self.centroids();
        let BinCount { ratio, min, max } = bin_count;
        let count = (self.boxes.len() as u32 / ratio).clamp(min, max) as usize;
        let binning = |axis: usize| {
            let least = centroids.min[axis];
            let length = f64::from(centroids.max[axis]) - f64::from(least);
            let factor = (count as f64 / length).min(f64::from(f32::MAX)) as f32;
            let bin = Box::new(move |own: &Aabb| {
                let place = (own.center()[axis] - least) * factor;
                place.min((count - 1) as f32) as usize
            });
            Binning { count, bin }
        };
        (0..3).map(binning).collect()
    }
}

/// Bins along one axis.
struct Binning {
    count: usize,
    bin: Box<dyn Fn(&Aabb) -> usize>,
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

/// Checks that nodes with more than `leaf_size` boxes are parted between bins, where that is cheapest.
fn check_bins(builder: &mut dyn BvhBuilder, leaf_size: usize, binnings: impl Fn(&Node) -> Vec<Binning>) {
    let settings = BvhSettings::default();
    let (mut splits, mut leaves) = (0, 0);
    for (name, family) in FAMILIES {
        for n in [3, 5, 8, 13, 40, 300] {
            for seed in 0..4 {
                let boxes = family(n, seed);
                let tree = built(builder, &boxes, &settings);
                for (index, depth) in depths(&tree).into_iter().enumerate() {
                    let node = Node::new(&tree, index, &boxes);
                    if node.is_low(depth) {
                        continue;
                    }
                    let label = format!("{name}, {n} boxes, seed {seed}, node {index}");
                    let binnings = binnings(&node);
                    let border_cost = |axis: &Binning, border| node.cost(&settings, |own| (axis.bin)(own) < border);
                    let borders = binnings
                        .iter()
                        .flat_map(|axis| (1..axis.count).map(move |border| (axis, border)));
                    let least = borders
                        .filter_map(|(axis, border)| border_cost(axis, border))
                        .min_by(f64::total_cmp);
                    let Some(children) = children(&tree, index) else {
                        if node.boxes.len() > leaf_size {
                            check_choice(&node, None, least, &settings, &label);
                            leaves += 1;
                        }
                        continue;
                    };
                    assert!(node.boxes.len() > leaf_size, "{label}");
                    let [left, right] = children.map(|child| Node::new(&tree, child, &boxes));
                    let found = binnings.iter().find_map(|axis| {
                        let border = right.boxes.iter().map(&axis.bin).min()?;
                        let is_it = left.boxes.iter().all(|own| (axis.bin)(own) < border);
                        is_it.then(|| border_cost(axis, border))?
                    });
                    assert!(found.is_some(), "{label}: not parted between bins");
                    check_choice(&node, found, least, &settings, &label);
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

#[test]
fn binned_splits_are_the_best_of_their_bins() {
    let mut builder = BinnedBvh::default();
    let leaf_size = builder.leaf_size;
    check_bins(&mut builder, leaf_size, Node::bins_of_binned);
}

#[test]
fn fused_splits_are_the_best_of_their_bins() {
    check_bins(&mut FusedBvh::default(), 1, |node| {
        node.bins_of_fused(BinCount::ACCURATE)
    });
    check_bins(&mut fast_fused(), 1, |node| node.bins_of_fused(BinCount::FAST));
}
