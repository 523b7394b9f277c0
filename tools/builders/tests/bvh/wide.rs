//! What a wide hierarchy promises, on every family of boxes, and that each fault in one is found.

use super::families::FAMILIES;
use restpose_builders::bvh::{WideBuilder, WideBvh, WideFault};
use restpose_formats::{
    geom::Aabb,
    rows::{MAX_WIDE_DEPTH, WideChild, WideNodeRow},
};
use restpose_runtime::build::{BvhSettings, CheckedBoxes};

fn built(builder: &mut WideBuilder, boxes: &[Aabb]) -> WideBvh {
    let mut tree = WideBvh::default();
    builder
        .build(CheckedBoxes::new(boxes).expect("good boxes"), &mut tree)
        .expect("few boxes");
    tree
}

#[test]
fn trees_are_valid_on_every_family() {
    let mut builder = WideBuilder::default();
    for (name, family) in FAMILIES {
        for n in (1..=40).chain([100, 1_000, 20_000]) {
            for seed in 0..3 {
                if n > 1_000 && seed > 0 {
                    continue;
                }
                let boxes = family(n, seed);
                let tree = built(&mut builder, &boxes);
                assert_eq!(tree.validate(&boxes), Ok(()), "{name}, {n} boxes, seed {seed}");
                assert!(tree.depth() <= MAX_WIDE_DEPTH);
                let cost = tree.sah_cost(&BvhSettings::default());
                assert!(
                    cost.is_finite() && cost >= 1.0,
                    "{name}, {n} boxes, seed {seed}: {cost}"
                );
                let fresh = built(&mut WideBuilder::default(), &boxes);
                assert_eq!(
                    tree, fresh,
                    "{name}, {n} boxes, seed {seed}: from what was built before"
                );
            }
        }
    }
}

#[test]
fn nodes_are_well_filled() {
    for (name, family) in FAMILIES {
        let tree = built(&mut WideBuilder::default(), &family(20_000, 1));
        // The lowest nodes, of two or three leaves, are met so rarely that it costs less to leave their places empty than any
        // above: sizes that double from box to box, where this goes farthest, fill 4.09 in the mean.
        assert!(tree.mean_children() > 4.0, "{name}: {}", tree.mean_children());
    }
}

#[test]
fn up_to_eight_boxes_make_one_node() {
    for (name, family) in FAMILIES {
        for n in 1..=8 {
            let tree = built(&mut WideBuilder::default(), &family(n, 1));
            assert_eq!((tree.nodes.len(), tree.depth()), (1, 1), "{name}, {n} boxes");
            assert_eq!(tree.mean_children(), n as f64);
        }
    }
}

#[test]
fn costs_are_those_of_equation_4_1() {
    // Ten unit cubes in a row, 10 × 1 × 1: half areas 3 of a cube, 2n + 1 of n cubes side by side, 21 of all.
    let boxes: Vec<Aabb> = (0u8..10)
        .map(|x| Aabb {
            min: [x.into(), 0.0, 0.0],
            max: [f32::from(x) + 1.0, 1.0, 1.0],
        })
        .collect();
    let tree = built(&mut WideBuilder::default(), &boxes);
    // Three cubes in a node of their own, or two and two in two; a node of three has 7/21.
    assert_eq!(tree.nodes.len(), 2);
    let settings = BvhSettings {
        traversal_cost: 2.0,
        intersection_cost: 3.0,
    };
    let expected = 2.0 * (1.0 + 7.0 / 21.0) + 3.0 * 10.0 * 3.0 / 21.0;
    let found = tree.sah_cost(&settings);
    // Boxes are wider by a step of the lattice at each end: 10/65535 along the row, less across.
    assert!(
        (expected..expected * (1.0 + 4e-4)).contains(&found),
        "{found}, expected {expected}"
    );
    assert_eq!(WideBvh::default().sah_cost(&settings), 0.0);
}

#[test]
fn each_fault_is_found() {
    let (_, family) = FAMILIES[0];
    let boxes = family(60, 5);
    let valid = built(&mut WideBuilder::default(), &boxes);
    assert!(valid.nodes.len() > 2);
    let inner = |node: &WideNodeRow| node.children().position(|child| matches!(child, WideChild::Node(_)));
    let leaves_only = valid
        .nodes
        .iter()
        .position(|node| inner(node).is_none())
        .expect("a lowest node");
    let leaf = |node: &WideNodeRow| node.children().position(|child| matches!(child, WideChild::Leaf(_)));
    let mixed = |node: &WideNodeRow| inner(node).is_some() && leaf(node).is_some();
    let fault = |change: &dyn Fn(&mut WideBvh)| {
        let mut tree = valid.clone();
        change(&mut tree);
        tree.validate(&boxes).expect_err("broken")
    };
    assert_eq!(WideBvh::default().validate(&boxes), Err(WideFault::NoNodes));
    assert!(matches!(
        fault(&|tree| tree.bounds.max[1] = tree.bounds.max[1].next_up()),
        WideFault::WrongBounds { .. }
    ));
    assert_eq!(
        fault(&|tree| tree.nodes[leaves_only] = WideNodeRow::EMPTY),
        WideFault::NoChildren { node: leaves_only }
    );
    let used = valid.nodes[leaves_only].children().count();
    assert!(used < 8, "a place to break");
    assert_eq!(
        fault(&|tree| tree.nodes[leaves_only].min[0][used] = 0),
        WideFault::NotEmpty {
            node: leaves_only,
            place: used
        }
    );
    let first_inner = inner(&valid.nodes[0]).expect("a node in the root");
    assert!(matches!(
        fault(&|tree| tree.nodes[0].children[first_inner] = WideChild::Node(2).pack()),
        WideFault::NotDepthFirst {
            node: 0,
            found: 2,
            expected: 1,
            ..
        }
    ));
    assert!(matches!(
        fault(&|tree| tree.nodes.truncate(1)),
        WideFault::NotDepthFirst { node: 0, .. }
    ));
    let count = valid.nodes.len();
    assert_eq!(
        fault(&|tree| tree.nodes.push(tree.nodes[leaves_only])),
        WideFault::Unreached {
            found: count + 1,
            expected: count
        }
    );
    let WideChild::Leaf(first) = WideChild::unpack(valid.nodes[leaves_only].children[0]) else {
        panic!("leaves only");
    };
    assert!(matches!(
        fault(&|tree| tree.nodes[leaves_only].children[0] = WideChild::Leaf(60).pack()),
        WideFault::UnknownBox {
            id: 60,
            box_count: 60,
            ..
        }
    ));
    assert!(matches!(
        fault(&|tree| tree.nodes[leaves_only].children[1] = tree.nodes[leaves_only].children[0]),
        WideFault::BoxNotListedOnce { id, times: 2 } if id == first as usize
    ));
    assert_eq!(
        valid.validate(&[&boxes[..], &boxes[..1]].concat()),
        Err(WideFault::BoxNotListedOnce { id: 60, times: 0 })
    );
    assert!(matches!(
        fault(&|tree| tree.references.swap(0, 1)),
        WideFault::WrongReferences { .. }
    ));
    assert!(matches!(
        fault(&|tree| tree.nodes[0].max[2][first_inner] -= 1),
        WideFault::WrongBox { node: 0, .. }
    ));
    let node = valid.nodes.iter().position(mixed).expect("a node with both");
    let (leaf, inner) = (leaf(&valid.nodes[node]).unwrap(), inner(&valid.nodes[node]).unwrap());
    let found = fault(&|tree| {
        let row = &mut tree.nodes[node];
        row.children.swap(leaf, inner);
        for k in 0..3 {
            row.min[k].swap(leaf, inner);
            row.max[k].swap(leaf, inner);
        }
    });
    assert!(matches!(found, WideFault::LeafBehindNode { .. }), "{found:?}");
}

#[test]
fn a_chain_that_is_too_deep_is_found() {
    let boxes = vec![Aabb::around([[0.0; 3], [1.0; 3]])];
    let leaf = built(&mut WideBuilder::default(), &boxes);
    let chain = |nodes: u32| {
        let link = |next| {
            let mut node = leaf.nodes[0];
            node.children[0] = WideChild::Node(next).pack();
            node
        };
        let nodes = (1..nodes).map(link).chain([leaf.nodes[0]]).collect();
        WideBvh { nodes, ..leaf.clone() }.validate(&boxes)
    };
    assert_eq!(chain(MAX_WIDE_DEPTH as u32), Ok(()));
    assert_eq!(
        chain(MAX_WIDE_DEPTH as u32 + 1),
        Err(WideFault::TooDeep { node: MAX_WIDE_DEPTH })
    );
}
