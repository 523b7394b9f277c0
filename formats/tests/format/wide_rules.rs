//! Rules of wide trees: each broken once.

use crate::{
    broken::{at, rules_of},
    fixture::{key_box, mover, read_copy, wide_model, wide_node},
};
use restpose_formats::{
    FormatError::*,
    Model,
    RowFault::*,
    SectionKind::*,
    TreeKind,
    geom::Aabb,
    rows::{ClusterBoneRow, KdNode, KdNodeRow, ReferenceBoxRow, WideChild, WideNodeRow},
    write,
};

rules_of! { broken_wide;
    wide_files_have_no_kd_nodes:
        |m| m.kd_nodes.push(KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 }))
        => RowsOfOtherTrees { section: KdNodes, found: 1, tree: TreeKind::Wide },
    wide_files_have_no_reference_boxes:
        |m| m.reference_boxes.push(ReferenceBoxRow::default())
        => RowsOfOtherTrees { section: ReferenceBoxes, found: 1, tree: TreeKind::Wide },
    clusters_cover_all_wide_nodes:
        |m| m.wide_nodes.push(m.wide_nodes[0]) => RowCount { section: WideNodes, expected: 9, found: 10 },
    a_wide_tree_has_a_root:
        |m| m.clusters[0].node_count = 0 => at!(Clusters, 0, EmptyRange { field: "node_count" }),

    wide_nodes_have_children:
        |m| m.wide_nodes[4] = WideNodeRow::EMPTY => at!(WideNodes, 4, NoChildren),
    empty_places_are_last:
        |m| m.wide_nodes[5].children[7] = m.wide_nodes[5].children[0]
        => at!(WideNodes, 5, PlaceBehindEmpty { place: 7 }),
    empty_places_have_no_least_corner:
        |m| m.wide_nodes[5].min[2][5] = 0 => at!(WideNodes, 5, BoxOfEmptyPlace { place: 5 }),
    empty_places_have_no_greatest_corner:
        |m| m.wide_nodes[4].max[0][1] = 65534 => at!(WideNodes, 4, BoxOfEmptyPlace { place: 1 }),
    wide_boxes_are_not_empty:
        |m| (m.wide_nodes[0].min[1][1], m.wide_nodes[0].max[1][1]) = (9, 8)
        => at!(WideNodes, 0, EmptyBox { field: "box", axis: 1, min: 9.0, max: 8.0 }),
    wide_boxes_lie_in_their_parents_above:
        |m| { deepen(m, 3); m.wide_nodes[0].min[2][0] += 1; }
        => at!(WideNodes, 1, OutsideParentsBox { place: 0, axis: 2, .. }),
    wide_boxes_lie_in_their_parents_below:
        |m| { deepen(m, 3); m.wide_nodes[1].max[0][0] -= 1; }
        => at!(WideNodes, 2, OutsideParentsBox { place: 0, axis: 0, max: 65535, greatest: 65534, .. }),
    boxes_that_follow_are_not_empty:
        |m| (m.wide_nodes[4].min[2][0], m.wide_nodes[4].max[2][0]) = (9, 8)
        => at!(WideNodes, 4, EmptyBox { field: "box", axis: 2, min: 9.0, max: 8.0 }),
    boxes_that_follow_lie_in_their_parents_above:
        |m| m.wide_nodes[2].min[1][0] += 1
        => at!(WideNodes, 3, OutsideParentsBox { place: 0, axis: 1, min: 0, least: 1, .. }),
    boxes_that_follow_lie_in_their_parents_below:
        |m| m.wide_nodes[3].max[2][0] += 1
        => at!(WideNodes, 3, OutsideParentsBox { place: 0, axis: 2, max: 32769, greatest: 32768, .. }),

    wide_children_are_in_range:
        |m| m.wide_nodes[1].children[0] = WideChild::Node(3).pack()
        => at!(WideNodes, 1, IndexOutOfRange { field: "child", found: 3, limit: 3 }),
    wide_children_stand_behind:
        |m| m.wide_nodes[2].children[0] = WideChild::Node(1).pack()
        => at!(WideNodes, 2, ChildNotBehind { found: 1, own: 1 }),
    wide_children_are_not_the_root:
        |m| m.wide_nodes[1].children[0] = WideChild::Node(0).pack()
        => at!(WideNodes, 1, ChildNotBehind { found: 0, own: 0 }),
    wide_nodes_have_one_parent:
        |m| m.wide_nodes[1].children[1] = WideChild::Node(1).pack() => at!(WideNodes, 1, TwoParents { child: 1 }),
    wide_nodes_but_the_root_have_a_parent:
        |m| m.wide_nodes[1].children[..2].copy_from_slice(&[2, 3].map(|triangle| WideChild::Leaf(triangle).pack()))
        => at!(WideNodes, 2, NoParent),
    a_wide_tree_is_not_too_deep: |m| deepen(m, 33) => at!(WideNodes, 32, TooDeep { found: 33, limit: 32 }),

    wide_leaves_are_of_the_references:
        |m| m.references[2] = 4
        => at!(WideNodes, 1, LeafNotReferenced { place: 1, found: 2, expected: 4 }),
    wide_leaves_are_in_the_order_of_rows:
        |m| m.references.swap(2, 3)
        => at!(WideNodes, 1, LeafNotReferenced { place: 1, found: 2, expected: 3 }),
    wide_leaves_have_a_reference:
        |m| m.wide_nodes[5] = wide_node(&[leaf_of(m, 5), (WideChild::Leaf(3), leaf_of(m, 5).1)])
        => at!(WideNodes, 5, LeafWithoutReference { place: 1 }),
    references_of_wide_trees_have_a_leaf:
        |m| m.wide_nodes[0] = wide_node(&[leaf_of(m, 0)]) => at!(References, 1, ReferenceUnused),
    wide_clusters_list_each_triangle_once:
        |m| {
            m.references[1] = 0;
            m.wide_nodes[0].children[1] = WideChild::Leaf(0).pack();
        }
        => at!(Clusters, 0, Count { field: "triangle_count", found: 2, expected: 1 }),
    wide_clusters_have_a_reference_per_triangle:
        |m| m.clusters[0].triangle_count = 1
        => at!(Clusters, 0, Count { field: "reference_count", found: 2, expected: 1 }),
    free_motion_has_no_wide_tree:
        |m| {
            m.wide_nodes.push(wide_node(&[(WideChild::Leaf(7), ReferenceBoxRow::default())]));
            m.clusters[7].node_count = 1;
        }
        => at!(Clusters, 7, Count { field: "node_count", found: 1, expected: 0 }),
    wide_leaves_are_triangles:
        |m| {
            m.references[4] = 10;
            m.wide_nodes[4].children[0] = WideChild::Leaf(10).pack();
        }
        => at!(References, 4, IndexOutOfRange { field: "triangle", found: 10, limit: 10 }),

    mover_ranges_follow_each_other:
        |m| m.wide_nodes[3].mover_first = 0
        => at!(WideNodes, 3, RangeNotContiguous { field: "mover_first", found: 0, expected: 1 }),
    mover_ranges_without_rows_follow_too:
        |m| m.wide_nodes[6].mover_first = 0
        => at!(WideNodes, 6, RangeNotContiguous { field: "mover_first", found: 0, expected: 3 }),
    mover_ranges_are_in_range:
        |m| m.wide_nodes[4].mover_count = 2
        => at!(WideNodes, 4, RangeOutOfBounds { field: "mover_first", first: 2, count: 2, limit: 3 }),
    mover_ranges_do_not_wrap:
        |m| m.wide_nodes[4].mover_count = u32::MAX
        => at!(WideNodes, 4, RangeOutOfBounds { field: "mover_first", .. }),
    wide_nodes_cover_all_movers:
        |m| m.node_movers.push(mover(0, 0, 0)) => RowCount { section: NodeMovers, expected: 3, found: 4 },
    movers_are_bones_of_the_cluster_beside_its_own:
        |m| m.node_movers[1].mover = 1
        => at!(NodeMovers, 1, IndexOutOfRange { field: "mover", found: 1, limit: 1 }),
    a_cluster_of_one_bone_has_no_movers:
        |m| add_mover(m, 0) => at!(NodeMovers, 0, IndexOutOfRange { field: "mover", found: 0, limit: 0 }),
    movers_are_among_the_first_eight:
        |m| {
            let row = m.cluster_bones[4];
            m.cluster_bones.splice(5..5, (3..12).map(|bone| ClusterBoneRow { bone, ..row }));
            m.clusters[2].cluster_bone_count += 9;
            m.clusters[3..].iter_mut().for_each(|cluster| cluster.cluster_bone_first += 9);
            m.node_movers[2].mover = 8;
        }
        => at!(NodeMovers, 2, IndexOutOfRange { field: "mover", found: 8, limit: 8 }),
    movers_of_a_node_ascend:
        |m| {
            add_bone_to_second(m);
            m.node_movers[1].mover = 1;
            m.node_movers.insert(2, mover(0, 0, 0));
            m.wide_nodes[3].mover_count = 2;
            m.wide_nodes[4..].iter_mut().for_each(|node| node.mover_first += 1);
        }
        => at!(NodeMovers, 2, NotAscending { field: "mover", found: 0, previous: 1 }),
    movers_of_a_node_are_distinct:
        |m| add_mover(m, 2) => at!(NodeMovers, 1, NotAscending { field: "mover", found: 0, previous: 0 }),
    empty_places_have_no_weight:
        |m| m.node_movers[0].weight[1] = 1 => at!(NodeMovers, 0, WeightOfEmptyPlace { place: 1 }),
    empty_places_have_no_spread:
        |m| m.node_movers[2].spread[7] = 1 => at!(NodeMovers, 2, WeightOfEmptyPlace { place: 7 }),
    clusters_with_a_track_have_no_movers:
        |m| {
            let flag = m.cluster_bones[6];
            m.cluster_bones.splice(7..7, [1, 2].map(|more| ClusterBoneRow { bone: flag.bone + more, ..flag }));
            m.clusters[4].cluster_bone_count += 2;
            m.clusters[5..].iter_mut().for_each(|cluster| cluster.cluster_bone_first += 2);
            add_mover(m, 5);
        }
        => at!(NodeMovers, 3, IndexOutOfRange { field: "mover", found: 0, limit: 0 }),
    clusters_without_a_lattice_have_no_movers:
        |m| m.cluster_bones[1..3].iter_mut().for_each(|row| row.bounds = Aabb::around([[1.0; 3]]))
        => at!(NodeMovers, 0, IndexOutOfRange { field: "mover", found: 0, limit: 0 }),

    boxes_at_keys_follow_each_other:
        |m| m.tracks[2].box_first = 0
        => at!(Tracks, 2, RangeNotContiguous { field: "box_first", found: 0, expected: 2 }),
    tracks_without_boxes_at_keys_follow_too:
        |m| { without_boxes(m, 2); m.tracks[2].box_first = 0; }
        => at!(Tracks, 2, RangeNotContiguous { field: "box_first", found: 0, expected: 2 }),
    boxes_at_keys_are_in_range:
        |m| { m.key_boxes.pop(); }
        => at!(Tracks, 3, RangeOutOfBounds { field: "box_first", first: 5, count: 4, limit: 8 }),
    trees_cover_all_boxes_at_keys:
        |m| m.key_boxes.push(key_box([1; 3], [1; 3])) => RowCount { section: KeyBoxes, expected: 9, found: 10 },
    the_last_key_has_boxes_or_stands_before_one_that_has:
        |m| m.tracks[1].box_interval = 1
        => at!(Tracks, 2, RangeNotContiguous { field: "box_first", found: 2, expected: 3 }),
    no_key_has_boxes_behind_one_that_is_not_before_the_last:
        |m| m.tracks[2].box_interval = 2
        => at!(Tracks, 3, RangeNotContiguous { field: "box_first", found: 5, expected: 4 }),
    boxes_at_keys_are_not_empty:
        |m| (m.key_boxes[3].min[1][0], m.key_boxes[3].max[1][0]) = (9, 8)
        => at!(KeyBoxes, 3, KeyBox { place: 0, axis: 1, min: 9, max: 8, expected: "`min` at most `max`" }),
    boxes_of_the_last_node_at_the_last_key_are_not_empty:
        |m| (m.key_boxes[8].min[2][0], m.key_boxes[8].max[2][0]) = (255, 0)
        => at!(KeyBoxes, 8, KeyBox { place: 0, axis: 2, min: 255, max: 0, .. }),
    empty_places_have_no_least_corner_at_a_key:
        |m| m.key_boxes[0].min[0][1] = 1
        => at!(KeyBoxes, 0, KeyBox { place: 1, axis: 0, min: 1, max: 0, expected: "zero in an empty place" }),
    empty_places_have_no_greatest_corner_at_a_key:
        |m| m.key_boxes[5].max[2][7] = 128
        => at!(KeyBoxes, 5, KeyBox { place: 7, axis: 2, min: 0, max: 128, expected: "zero in an empty place" }),
    empty_places_have_no_box_at_a_key:
        |m| (m.key_boxes[6].min[1][4], m.key_boxes[6].max[1][4]) = (2, 2)
        => at!(KeyBoxes, 6, KeyBox { place: 4, axis: 1, min: 2, max: 2, expected: "zero in an empty place" }),
    boxes_of_all_nodes_at_a_key_stand_together:
        |m| { fill_second_place_of_last_root(m); m.key_boxes.swap(6, 7); }
        => at!(KeyBoxes, 6, KeyBox { place: 1, axis: 0, min: 1, max: 2, .. }),
}

/// Takes the boxes at keys of a track's cluster away, so that the next row is that of the cluster behind.
fn without_boxes(model: &mut Model, track: usize) {
    let [first, end] = [track, track + 1].map(|track| model.tracks[track].box_first as usize);
    model.key_boxes.drain(first..end);
    model.tracks[track].box_interval = 0;
    for track in &mut model.tracks[track + 1..] {
        track.box_first = track.box_first.saturating_sub((end - first) as u32);
    }
}

/// Gives the last tree the triangle that moves freely beside it, in its root, of which then one place more is in use than of the
/// node below.
fn fill_second_place_of_last_root(model: &mut Model) {
    let free = model.clusters.pop().expect("a cluster in free motion");
    model.segments[2].cluster_count -= 1;
    let tree = &mut model.clusters[6];
    (tree.triangle_count, tree.reference_count) = (2, 2);
    model.references.swap(8, 9);
    for at in 0..tree.cluster_bone_count {
        let more = model.cluster_bones[(free.cluster_bone_first + at) as usize];
        let row = &mut model.cluster_bones[(tree.cluster_bone_first + at) as usize];
        assert_eq!(row.bone, more.bone);
        row.bounds = row.bounds.union(more.bounds);
    }
    model.cluster_bones.truncate(free.cluster_bone_first as usize);
    let below = (WideChild::Node(1), leaf_of(model, 7).1);
    let root = wide_node(&[below, (WideChild::Leaf(7), below.1)]);
    model.wide_nodes[7] = WideNodeRow { mover_first: 3, ..root };
    for row in [5, 7] {
        let row = &mut model.key_boxes[row];
        for k in 0..3 {
            (row.min[k][1], row.max[k][1]) = (1, 2);
        }
    }
}

/// Gives a node one mover more, bone 0 of the others, in the first row of all that are not before it.
fn add_mover(model: &mut Model, node: usize) {
    let row = &mut model.wide_nodes[node];
    let at = row.mover_first + row.mover_count;
    row.mover_count += 1;
    model.node_movers.insert(at as usize, mover(0, 1, 1));
    for node in &mut model.wide_nodes[node + 1..] {
        node.mover_first += 1;
    }
}

/// Lists bone 0 among the bones of the second cluster, which then has two others.
fn add_bone_to_second(model: &mut Model) {
    let row = ClusterBoneRow {
        bone: 0,
        ..model.cluster_bones[1]
    };
    model.cluster_bones.insert(1, row);
    model.clusters[1].cluster_bone_count += 1;
    for cluster in &mut model.clusters[2..] {
        cluster.cluster_bone_first += 1;
    }
}

/// The child in the first place of a node, and its box.
fn leaf_of(model: &Model, node: usize) -> (WideChild, ReferenceBoxRow) {
    let node = &model.wide_nodes[node];
    let [min, max] = [&node.min, &node.max].map(|corner| [corner[0][0], corner[1][0], corner[2][0]]);
    (WideChild::unpack(node.children[0]), ReferenceBoxRow { min, max })
}

/// Gives the first cluster a chain of `count` nodes, the last of which has its leaves.
fn deepen(model: &mut Model, count: u32) {
    let whole = ReferenceBoxRow {
        min: [0; 3],
        max: [u16::MAX; 3],
    };
    let chain = (1..count).map(|child| wide_node(&[(WideChild::Node(child), whole)]));
    model.wide_nodes.splice(0..0, chain.collect::<Vec<_>>());
    model.clusters[0].node_count = count;
    for cluster in &mut model.clusters[1..] {
        cluster.node_first += count - 1;
    }
}

#[test]
fn a_wide_tree_of_the_greatest_depth_is_accepted() {
    let mut model = wide_model();
    deepen(&mut model, 32);
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn wide_boxes_may_lie_in_a_plane_and_fill_the_lattice() {
    let mut model = wide_model();
    for axis in 0..3 {
        (model.wide_nodes[0].min[axis][0], model.wide_nodes[0].max[axis][0]) = (0, u16::MAX);
        (model.wide_nodes[0].min[axis][1], model.wide_nodes[0].max[axis][1]) = (7, 7);
    }
    assert!(write(&model).is_ok());
}

#[test]
fn boxes_of_different_kinds_need_not_lie_in_each_other() {
    let mut model = wide_model();
    let [above, below] = [&model.wide_nodes[1], &model.wide_nodes[2]].map(|node| [node.min[0][0], node.max[0][0]]);
    assert!(
        below[0] < above[0] && above[1] < below[1],
        "a box that follows is wider than the fuzzy one above"
    );
    assert!(write(&model).is_ok());
    // And a fuzzy one below boxes that follow.
    model.node_movers.remove(1);
    model.wide_nodes[3].mover_count = 0;
    for node in &mut model.wide_nodes[4..] {
        node.mover_first -= 1;
    }
    (model.wide_nodes[3].min[2][0], model.wide_nodes[3].max[2][0]) = (40_000, 50_000);
    assert!(model.wide_nodes[2].max[2][0] < 40_000);
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn boxes_that_follow_may_lie_in_a_plane_and_fill_the_lattice() {
    let mut model = wide_model();
    for axis in 0..3 {
        for node in 2..4 {
            (model.wide_nodes[node].min[axis][0], model.wide_nodes[node].max[axis][0]) = (0, u16::MAX);
        }
        (model.wide_nodes[4].min[axis][0], model.wide_nodes[4].max[axis][0]) = (7, 7);
    }
    model.node_movers[0] = mover(0, u16::MAX, u16::MAX);
    assert!(write(&model).is_ok());
}

#[test]
fn boxes_at_keys_may_lie_in_a_plane_and_reach_beyond_those_of_the_segment() {
    let mut model = wide_model();
    model.key_boxes[2] = key_box([0; 3], [u8::MAX; 3]);
    model.key_boxes[3] = key_box([0; 3], [0; 3]);
    model.key_boxes[4] = key_box([u8::MAX; 3], [u8::MAX; 3]);
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn a_cluster_between_others_may_have_no_boxes_at_keys() {
    let mut model = wide_model();
    without_boxes(&mut model, 2);
    assert_eq!([1, 2, 3].map(|track| model.tracks[track].box_first), [0, 2, 2]);
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn boxes_at_keys_may_be_further_apart_than_the_segment_is_long() {
    let mut model = wide_model();
    model.tracks[1].box_interval = u32::MAX;
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}

#[test]
fn nodes_of_a_tree_have_different_places_in_use_at_keys() {
    let mut model = wide_model();
    fill_second_place_of_last_root(&mut model);
    let bytes = write(&model).expect("the model is valid");
    assert_eq!(read_copy(&bytes), Ok(model));
}
