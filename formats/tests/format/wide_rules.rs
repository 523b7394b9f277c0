//! Rules of wide trees: each broken once.

use crate::{
    broken::{at, rules_of},
    fixture::{read_copy, wide_model, wide_node},
};
use restpose_formats::{
    FormatError::*,
    Model,
    RowFault::*,
    SectionKind::*,
    TreeKind,
    rows::{KdNode, KdNodeRow, ReferenceBoxRow, WideChild, WideNodeRow},
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
        |m| m.wide_nodes.push(m.wide_nodes[0]) => RowCount { section: WideNodes, expected: 7, found: 8 },
    a_wide_tree_has_a_root:
        |m| m.clusters[0].node_count = 0 => at!(Clusters, 0, EmptyRange { field: "node_count" }),

    wide_nodes_have_children:
        |m| m.wide_nodes[3] = WideNodeRow::EMPTY => at!(WideNodes, 3, NoChildren),
    empty_places_are_last:
        |m| m.wide_nodes[3].children[7] = m.wide_nodes[3].children[0]
        => at!(WideNodes, 3, PlaceBehindEmpty { place: 7 }),
    empty_places_have_no_least_corner:
        |m| m.wide_nodes[3].min[2][5] = 0 => at!(WideNodes, 3, BoxOfEmptyPlace { place: 5 }),
    empty_places_have_no_greatest_corner:
        |m| m.wide_nodes[3].max[0][1] = 65534 => at!(WideNodes, 3, BoxOfEmptyPlace { place: 1 }),
    wide_boxes_are_not_empty:
        |m| (m.wide_nodes[0].min[1][1], m.wide_nodes[0].max[1][1]) = (9, 8)
        => at!(WideNodes, 0, EmptyBox { field: "box", axis: 1, min: 9.0, max: 8.0 }),
    wide_boxes_lie_in_their_parents_above:
        |m| m.wide_nodes[1].min[2][0] += 1 => at!(WideNodes, 2, OutsideParentsBox { place: 0, axis: 2, .. }),
    wide_boxes_lie_in_their_parents_below:
        |m| m.wide_nodes[2].max[0][0] += 1 => at!(WideNodes, 2, OutsideParentsBox { place: 0, axis: 0, .. }),

    wide_children_are_in_range:
        |m| m.wide_nodes[1].children[0] = WideChild::Node(2).pack()
        => at!(WideNodes, 1, IndexOutOfRange { field: "child", found: 2, limit: 2 }),
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
        |m| m.wide_nodes[3] = wide_node(&[leaf_of(m, 3), (WideChild::Leaf(3), leaf_of(m, 3).1)])
        => at!(WideNodes, 3, LeafWithoutReference { place: 1 }),
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
            m.wide_nodes[3].children[0] = WideChild::Leaf(10).pack();
        }
        => at!(References, 4, IndexOutOfRange { field: "triangle", found: 10, limit: 10 }),
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
