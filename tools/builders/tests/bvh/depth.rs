use super::builders::all_bvh_builders;
use super::families::exponential;
use super::tree_sets::{built, depths};
use restpose_builders::bvh::{BinnedBvh, BvhBuilder, MedianBvh, SweepBvh};
use restpose_runtime::build::{BvhSettings, MAX_BVH_DEPTH};

/// Splits always pay.
const FREE: BvhSettings = BvhSettings {
    traversal_cost: -1.0,
    intersection_cost: 1.0,
};

#[test]
fn the_deepest_trees_stay_within_the_limit() {
    for entry in all_bvh_builders() {
        for n in [70, 250, 1_000, 30_000] {
            let boxes = exponential(n, 0);
            let tree = built(&mut *(entry.make)(), &boxes, &FREE);
            assert_eq!(tree.validate(&boxes), Ok(()), "{}, {n} boxes", entry.name);
        }
    }
}

#[test]
fn the_limit_is_reached_where_it_binds() {
    let boxes = exponential(1_000, 0);
    let mut median = MedianBvh::default();
    median.leaf_size = 1;
    let mut binned = BinnedBvh::default();
    binned.leaf_size = 1;
    let builders: [&mut dyn BvhBuilder; 3] = [&mut median, &mut binned, &mut SweepBvh::default()];
    for builder in builders {
        let tree = built(builder, &boxes, &FREE);
        assert_eq!(depths(&tree).into_iter().max(), Some(MAX_BVH_DEPTH));
    }
}
