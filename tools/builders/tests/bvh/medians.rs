use super::families::scattered;
use super::tree_sets::{built, children, listed};
use restpose_builders::bvh::{GridBvh, MedianBvh};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhSettings};

fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds))
}

/// The box halved across its longest side: axis, plane.
fn median(voxel: &Aabb) -> (usize, f32) {
    let length = |k: usize| voxel.max[k] - voxel.min[k];
    let axis = (0..3).fold(0, |a, b| if length(b) > length(a) { b } else { a });
    (axis, 0.5 * (voxel.min[axis] + voxel.max[axis]))
}

/// Checks that nodes with more than `leaf_size` boxes are parted as halving voxels parts them, for so many halvings.
fn check(tree: &Bvh, boxes: &[Aabb], leaf_size: usize, halvings: usize) -> usize {
    let mut checked = 0;
    let mut open = vec![(0, around(boxes), halvings)];
    while let Some((node, voxel, halvings)) = open.pop() {
        let ids = listed(tree, node);
        if ids.len() <= leaf_size || halvings == 0 {
            continue;
        }
        let (axis, plane) = median(&voxel);
        let (mut lower, mut upper) = (voxel, voxel);
        lower.max[axis] = plane;
        upper.min[axis] = plane;
        let (left, right): (Vec<u32>, Vec<u32>) =
            ids.iter().partition(|id| boxes[**id as usize].center()[axis] < plane);
        if left.is_empty() || right.is_empty() {
            let half = if left.is_empty() { upper } else { lower };
            open.push((node, half, halvings - 1));
            continue;
        }
        let [a, b] = children(tree, node).unwrap();
        assert_eq!(
            [listed(tree, a), listed(tree, b)],
            [left, right],
            "node {node}, axis {axis}, {plane}"
        );
        checked += 1;
        open.extend([(a, lower, halvings - 1), (b, upper, halvings - 1)]);
    }
    checked
}

#[test]
fn voxels_are_halved_and_not_boxes() {
    // Halves of 0 to 10: 5, then 2.5 and 1.25 below. The middle of the three left ones would be 1.
    let boxes = [0.0, 1.0, 2.0, 10.0].map(|x| Aabb {
        min: [x, 0.0, 0.0],
        max: [x, 0.0, 0.0],
    });
    let mut builder = MedianBvh::default();
    builder.leaf_size = 1;
    let tree = built(&mut builder, &boxes, &BvhSettings::default());
    let [left, right] = children(&tree, 0).unwrap();
    assert_eq!([listed(&tree, left), listed(&tree, right)], [vec![0, 1, 2], vec![3]]);
    let [left, right] = children(&tree, left).unwrap();
    assert_eq!([listed(&tree, left), listed(&tree, right)], [vec![0, 1], vec![2]]);
}

#[test]
fn median_nodes_are_halved_voxels() {
    for (seed, size) in [(1, 0.0), (2, 5.0), (3, 60.0)] {
        let boxes = scattered(3_000, seed, 50.0, size);
        let tree = built(&mut MedianBvh::default(), &boxes, &BvhSettings::default());
        assert!(check(&tree, &boxes, 2, usize::MAX) > 1_000);
    }
}

#[test]
fn grid_nodes_are_halved_voxels_seven_times() {
    for (seed, size) in [(1, 0.0), (2, 5.0), (3, 60.0)] {
        let mut boxes = scattered(30_000, seed, 50.0, size);
        // An L, so that some cells are empty, and sides of three lengths.
        boxes.retain(|bounds| bounds.min[0] < 0.0 || bounds.min[1] < 0.0);
        for bounds in &mut boxes {
            bounds.min[1] *= 0.3;
            bounds.max[1] *= 0.3;
        }
        let tree = built(&mut GridBvh::default(), &boxes, &BvhSettings::default());
        assert!(check(&tree, &boxes, 1, 7) > 60);
    }
}
