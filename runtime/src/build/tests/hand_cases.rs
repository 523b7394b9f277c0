use crate::build::{KdBuilder, KdSettings, KdTree};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, MAX_KD_DEPTH};

fn built(boxes: &[Aabb], settings: &KdSettings) -> KdTree {
    let mut tree = KdTree::default();
    KdBuilder::new().build(boxes, settings, &mut tree);
    assert_eq!(tree.validate(boxes), Ok(()));
    tree
}

fn nodes(tree: &KdTree) -> Vec<KdNode> {
    tree.nodes.iter().map(|row| row.unpack()).collect()
}

fn cube(min: [f32; 3], side: f32) -> Aabb {
    Aabb {
        min,
        max: min.map(|x| x + side),
    }
}

#[test]
fn no_boxes_and_empty_boxes_give_an_empty_leaf() {
    for boxes in [&[][..], &[Aabb::EMPTY; 3]] {
        let tree = built(boxes, &KdSettings::default());
        assert_eq!(nodes(&tree), [KdNode::Leaf { first: 0, count: 0 }]);
        assert_eq!((tree.references, tree.bounds), (vec![], Aabb::EMPTY));
    }
}

#[test]
fn one_box_gives_one_leaf() {
    let bounds = cube([1.0, 2.0, 3.0], 4.0);
    let tree = built(&[Aabb::EMPTY, bounds], &KdSettings::default());
    assert_eq!(nodes(&tree), [KdNode::Leaf { first: 0, count: 1 }]);
    assert_eq!((tree.references, tree.bounds), (vec![1], bounds));
}

#[test]
fn two_boxes_apart_are_parted_at_the_side_of_the_first() {
    // Bounds 5 × 1 × 1, half area 11. Both planes, 1 and 4, cost 1 + 1.5 · (3 + 9) / 11 = 2.64 < 3: the lower one wins.
    // Then the right cell of 4 × 1 × 1, half area 9, has 3 × 1 × 1 cut off: 0.8 · (1 + 1.5 · 3 / 9) = 1.2 < 1.5.
    let tree = built(
        &[cube([0.0; 3], 1.0), cube([4.0, 0.0, 0.0], 1.0)],
        &KdSettings::default(),
    );
    assert_eq!(
        nodes(&tree),
        [
            KdNode::Inner {
                axis: 0,
                split: 1.0,
                left: 1
            },
            KdNode::Leaf { first: 1, count: 1 },
            KdNode::Inner {
                axis: 0,
                split: 4.0,
                left: 3
            },
            KdNode::Leaf { first: 1, count: 0 },
            KdNode::Leaf { first: 0, count: 1 },
        ]
    );
    assert_eq!(tree.references, [1, 0]);
}

#[test]
fn equal_costs_take_the_lowest_axis() {
    let corners = [[0.0; 3], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]];
    for rotation in 0..3 {
        let boxes: Vec<_> = corners
            .iter()
            .map(|corner| cube(std::array::from_fn(|k| corner[(k + rotation) % 3]), 1.0))
            .collect();
        let root = nodes(&built(&boxes, &KdSettings::default()))[0];
        // One box beyond x = 1 in a plane's thick part costs the same on each axis.
        assert_eq!(
            root,
            KdNode::Inner {
                axis: 0,
                split: 1.0,
                left: 1
            },
            "rotation {rotation}"
        );
    }
}

#[test]
fn without_a_bonus_empty_space_is_cut_only_where_that_pays() {
    let boxes = [cube([0.0; 3], 1.0), cube([4.0, 0.0, 0.0], 1.0)];
    let dear = KdSettings {
        traversal_cost: 2.0,
        empty_bonus: 1.0,
        ..KdSettings::default()
    };
    assert_eq!(nodes(&built(&boxes, &dear)), [KdNode::Leaf { first: 0, count: 2 }]);
    // 1 + 1.5 · 3 / 9 = 1.5 is not cheaper than the leaf's 1.5.
    let plain = KdSettings {
        empty_bonus: 1.0,
        ..KdSettings::default()
    };
    assert_eq!(built(&boxes, &plain).nodes.len(), 3);
}

#[test]
fn boxes_in_the_plane_go_to_the_cheaper_side() {
    // Walls in the plane x = 2, slabs from 0 to 2 before them, one thing far behind: the walls go with the slabs, so
    // that the large cell behind has one box; then they get a flat cell, 1 + 1.5 · (5 + 5 · 100 / 140) < 15.
    let wall = Aabb {
        min: [2.0, 0.0, 0.0],
        max: [2.0, 10.0, 10.0],
    };
    let slab = Aabb {
        min: [0.0; 3],
        max: [2.0, 10.0, 10.0],
    };
    let mut boxes = vec![wall; 5];
    boxes.extend([slab; 5]);
    boxes.push(cube([9.0, 0.0, 0.0], 1.0));
    let tree = built(&boxes, &KdSettings::default());
    let nodes = nodes(&tree);
    assert_eq!(
        nodes[0],
        KdNode::Inner {
            axis: 0,
            split: 2.0,
            left: 1
        }
    );
    let KdNode::Inner {
        axis: 0,
        split: 2.0,
        left,
    } = nodes[1]
    else {
        panic!("{nodes:?}")
    };
    let leaf = |index: u32| match nodes[index as usize] {
        KdNode::Leaf { first, count } => &tree.references[first as usize..(first + count) as usize],
        KdNode::Inner { .. } => panic!("{nodes:?}"),
    };
    assert_eq!(
        (leaf(left), leaf(left + 1)),
        (&[5, 6, 7, 8, 9][..], &[0, 1, 2, 3, 4][..])
    );
}

#[test]
fn boxes_in_the_plane_go_left_where_both_sides_cost_the_same() {
    // Mirrored at x = 2.
    let slab = |min: f32| Aabb {
        min: [min, 0.0, 0.0],
        max: [min + 2.0, 10.0, 10.0],
    };
    let mut boxes = vec![slab(0.0); 5];
    boxes.extend([slab(2.0); 5]);
    boxes.push(Aabb {
        min: [2.0, 0.0, 0.0],
        max: [2.0, 10.0, 10.0],
    });
    let tree = built(&boxes, &KdSettings::default());
    assert_eq!(
        nodes(&tree)[0],
        KdNode::Inner {
            axis: 0,
            split: 2.0,
            left: 1
        }
    );
    assert_eq!(nodes(&tree)[2], KdNode::Leaf { first: 0, count: 5 });
}

#[test]
fn a_wall_on_the_border_gets_a_flat_cell() {
    let mut boxes = vec![
        Aabb {
            min: [0.0; 3],
            max: [0.0, 1.0, 1.0]
        };
        50
    ];
    boxes.push(Aabb {
        min: [0.0; 3],
        max: [40.0, 1.0, 1.0],
    });
    let tree = built(&boxes, &KdSettings::default());
    assert_eq!(
        nodes(&tree)[0],
        KdNode::Inner {
            axis: 0,
            split: 0.0,
            left: 1
        }
    );
    assert_eq!(nodes(&tree)[1], KdNode::Leaf { first: 1, count: 50 });
    assert_eq!(nodes(&tree)[2], KdNode::Leaf { first: 0, count: 1 });
}

#[test]
fn identical_boxes_stay_together() {
    for count in [2, 10_000] {
        for bounds in [
            cube([1.0; 3], 2.0),
            cube([1.0; 3], 0.0),
            Aabb {
                min: [0.0; 3],
                max: [0.0, 1.0, 1.0],
            },
        ] {
            let tree = built(&vec![bounds; count], &KdSettings::default());
            assert_eq!(
                nodes(&tree),
                [KdNode::Leaf {
                    first: 0,
                    count: count as u32
                }]
            );
        }
    }
}

#[test]
fn depth_ends_at_the_limit() {
    // Each box is half as far from the origin as the one before: a chain of planes as long as the exponents reach.
    let boxes: Vec<_> = (0..250)
        .map(|i| f32::exp2(120.0 - i as f32))
        .map(|x| cube([x; 3], 0.5 * x))
        .collect();
    let cheap = KdSettings {
        traversal_cost: 1e-3,
        ..KdSettings::default()
    };
    let tree = built(&boxes, &cheap);
    let mut depth = vec![0; tree.nodes.len()];
    for (index, node) in nodes(&tree).into_iter().enumerate() {
        if let KdNode::Inner { left, .. } = node {
            depth[left as usize] = depth[index] + 1;
            depth[left as usize + 1] = depth[index] + 1;
        }
    }
    assert_eq!(depth.into_iter().max(), Some(MAX_KD_DEPTH));
}
