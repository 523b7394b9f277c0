use super::families::FAMILIES;
use crate::build::{KdBuilder, KdFault, KdSettings, KdTree};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, KdNodeRow};

/// A tree of three leaves over three cubes in a row.
fn sound() -> (Vec<Aabb>, KdTree) {
    let boxes: Vec<_> = [0.0, 4.0, 9.0]
        .map(|x| Aabb {
            min: [x, 0.0, 0.0],
            max: [x + 1.0, 1.0, 1.0],
        })
        .to_vec();
    let nodes = [
        KdNode::Inner {
            axis: 0,
            split: 2.0,
            left: 1,
        },
        KdNode::Leaf { first: 0, count: 1 },
        KdNode::Inner {
            axis: 0,
            split: 4.5,
            left: 3,
        },
        KdNode::Leaf { first: 1, count: 1 },
        KdNode::Leaf { first: 2, count: 2 },
    ];
    let tree = KdTree {
        nodes: nodes.map(KdNodeRow::pack).to_vec(),
        references: vec![0, 1, 1, 2],
        bounds: Aabb {
            min: [0.0; 3],
            max: [10.0, 1.0, 1.0],
        },
    };
    assert_eq!(tree.validate(&boxes), Ok(()));
    (boxes, tree)
}

/// Breaks a tree or its boxes in one place.
type Spoil = fn(&mut Vec<Aabb>, &mut KdTree);

#[test]
fn each_fault_is_named() {
    let cases: [(KdFault, Spoil); 15] = [
        (KdFault::NoNodes, |_, tree| tree.nodes.clear()),
        (
            KdFault::ChildOutOfRange {
                node: 0,
                left: 4,
                node_count: 5,
            },
            |_, tree| {
                tree.nodes[0] = KdNodeRow::pack(KdNode::Inner {
                    axis: 0,
                    split: 2.0,
                    left: 4,
                });
            },
        ),
        (
            KdFault::ChildOutOfRange {
                node: 2,
                left: 2,
                node_count: 5,
            },
            |_, tree| {
                tree.nodes[2] = KdNodeRow::pack(KdNode::Inner {
                    axis: 0,
                    split: 4.5,
                    left: 2,
                });
            },
        ),
        (KdFault::NotATree { node: 3, times: 2 }, |_, tree| {
            tree.nodes[0] = KdNodeRow::pack(KdNode::Inner {
                axis: 0,
                split: 4.5,
                left: 2,
            });
            tree.nodes[3] = KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 });
            tree.nodes[4] = KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 });
        }),
        (KdFault::NotATree { node: 5, times: 0 }, |_, tree| {
            tree.nodes.push(tree.nodes[1])
        }),
        (
            KdFault::SplitOutsideCell {
                node: 2,
                axis: 0,
                split: 1.5,
                min: 2.0,
                max: 10.0,
            },
            |_, tree| {
                tree.nodes[2] = KdNodeRow::pack(KdNode::Inner {
                    axis: 0,
                    split: 1.5,
                    left: 3,
                });
            },
        ),
        (
            KdFault::ReferencesOutOfRange {
                node: 4,
                first: 2,
                count: 3,
                available: 4,
            },
            |_, tree| {
                tree.nodes[4] = KdNodeRow::pack(KdNode::Leaf { first: 2, count: 3 });
            },
        ),
        (
            KdFault::ReferencesOutOfOrder {
                node: 4,
                previous: 2,
                next: 1,
            },
            |_, tree| tree.references.swap(2, 3),
        ),
        (
            KdFault::ReferencesNotPartitioned { reference: 2, times: 2 },
            |_, tree| {
                tree.nodes[3] = KdNodeRow::pack(KdNode::Leaf { first: 2, count: 1 });
            },
        ),
        (
            KdFault::ReferencesNotPartitioned { reference: 4, times: 0 },
            |_, tree| tree.references.push(0),
        ),
        (
            KdFault::UnknownBox {
                node: 4,
                id: 3,
                box_count: 3,
            },
            |_, tree| tree.references[3] = 3,
        ),
        (KdFault::BoxMissesCell { node: 4, id: 0 }, |_, tree| {
            tree.references[2] = 0
        }),
        (KdFault::BoxMissesCell { node: 1, id: 0 }, |boxes, _| {
            boxes[0] = Aabb::EMPTY
        }),
        (KdFault::BoundsTooSmall { id: 1 }, |boxes, _| {
            boxes[1].min[1] = -f32::MIN_POSITIVE
        }),
        (KdFault::BoxNotListed { node: 1, id: 1 }, |boxes, _| {
            boxes[1].min[0] = 2.0f32.next_down()
        }),
    ];
    for (expected, spoil) in cases {
        let (mut boxes, mut tree) = sound();
        spoil(&mut boxes, &mut tree);
        assert_eq!(tree.validate(&boxes), Err(expected));
    }
}

#[test]
fn touching_a_leaf_from_outside_needs_no_reference() {
    let (mut boxes, tree) = sound();
    boxes[1].min[0] = 2.0;
    assert_eq!(tree.validate(&boxes), Ok(()));
    // In the plane itself, one side is enough, but one there must be.
    boxes.push(Aabb {
        min: [4.5, 0.0, 0.0],
        max: [4.5, 1.0, 1.0],
    });
    assert!(matches!(
        tree.validate(&boxes),
        Err(KdFault::BoxNotListed { id: 3, .. })
    ));
    let mut left = tree.clone();
    left.references = vec![0, 1, 3, 1, 2];
    left.nodes[3] = KdNodeRow::pack(KdNode::Leaf { first: 1, count: 2 });
    left.nodes[4] = KdNodeRow::pack(KdNode::Leaf { first: 3, count: 2 });
    assert_eq!(left.validate(&boxes), Ok(()));
    let mut right = tree;
    right.references = vec![0, 1, 1, 2, 3];
    right.nodes[4] = KdNodeRow::pack(KdNode::Leaf { first: 2, count: 3 });
    assert_eq!(right.validate(&boxes), Ok(()));
}

#[test]
fn paths_beyond_the_depth_limit_are_refused() {
    let tree = |inner: u32| {
        // Each level has a leaf at an odd row and the next level's node behind it.
        let mut nodes = vec![];
        for level in 0..inner {
            nodes.push(KdNodeRow::pack(KdNode::Inner {
                axis: 0,
                split: 0.0,
                left: 2 * level + 1,
            }));
            nodes.push(KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 }));
        }
        nodes.push(KdNodeRow::pack(KdNode::Leaf { first: 0, count: 0 }));
        KdTree {
            nodes,
            references: vec![],
            bounds: Aabb {
                min: [0.0; 3],
                max: [1.0; 3],
            },
        }
    };
    assert_eq!(tree(62).validate(&[]), Ok(()));
    assert_eq!(tree(63).validate(&[]), Err(KdFault::TooDeep { node: 124 }));
}

#[test]
fn a_lost_reference_never_passes() {
    // Where the box overlaps the leaf's cell with some of its extent, no other leaf can stand in.
    for (name, family) in FAMILIES {
        let boxes = family(30, 8);
        let mut tree = KdTree::default();
        KdBuilder::new().build(&boxes, &KdSettings::default(), &mut tree);
        for node in 0..tree.nodes.len() {
            let KdNode::Leaf { first, count } = tree.nodes[node].unpack() else {
                continue;
            };
            if count == 0 {
                continue;
            }
            let mut spoiled = tree.clone();
            // The leaf's last reference goes; later leaves move down.
            spoiled.references.remove((first + count - 1) as usize);
            for row in &mut spoiled.nodes {
                if let KdNode::Leaf { first: f, count: c } = row.unpack() {
                    let f = if f > first { f - 1 } else { f };
                    *row = KdNodeRow::pack(KdNode::Leaf { first: f, count: c });
                }
            }
            spoiled.nodes[node] = KdNodeRow::pack(KdNode::Leaf {
                first,
                count: count - 1,
            });
            assert!(
                matches!(spoiled.validate(&boxes), Err(KdFault::BoxNotListed { .. })),
                "{name}: {:?} without the last of leaf {node}",
                spoiled.validate(&boxes)
            );
        }
    }
}
