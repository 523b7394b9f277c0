use super::builders::all_bvh_builders;
use super::families::{FAMILIES, scattered};
use super::tree_sets::built;
use restpose_builders::bvh::{SweepBvh, refit, refit_parallel};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhFault, BvhNode, BvhSettings, CheckedBoxes};

type Refit = fn(&mut Bvh, CheckedBoxes<'_>) -> Result<(), BvhFault>;

const WAYS: [(&str, Refit); 2] = [
    ("one thread", |tree, boxes| refit(tree, boxes)),
    ("all threads", |tree, boxes| refit_parallel(tree, boxes)),
];

#[test]
fn refitted_trees_are_valid_for_the_new_boxes() {
    for entry in all_bvh_builders() {
        for (name, family) in FAMILIES {
            for n in [1, 2, 9, 500] {
                let tree = built(&mut *(entry.make)(), &family(n, 1), &BvhSettings::default());
                let moved = scattered(n, 2, 10.0, 1.0);
                for (way, refit) in WAYS {
                    let mut refitted = tree.clone();
                    refit(&mut refitted, CheckedBoxes::new(&moved).unwrap()).unwrap();
                    let label = format!("{}, {name}, {n} boxes, {way}", entry.name);
                    assert_eq!(refitted.validate(&moved), Ok(()), "{label}");
                    assert_eq!(refitted.references, tree.references, "{label}");
                    let contents = |tree: &Bvh| tree.nodes.iter().map(BvhNode::content).collect::<Vec<_>>();
                    assert_eq!(contents(&refitted), contents(&tree), "{label}");
                }
            }
        }
    }
}

#[test]
fn what_is_not_there_is_a_fault() {
    let boxes = scattered(9, 1, 10.0, 1.0);
    let bounds = Aabb::EMPTY;
    for (way, refit) in WAYS {
        let fault = |change: &dyn Fn(&mut Bvh), count: usize| {
            let mut tree = built(&mut SweepBvh::default(), &boxes, &BvhSettings::default());
            change(&mut tree);
            refit(&mut tree, CheckedBoxes::new(&scattered(count, 1, 10.0, 1.0)).unwrap()).unwrap_err()
        };
        let none = |_: &mut Bvh| {};
        assert_eq!(fault(&|tree| *tree = Bvh::default(), 9), BvhFault::NoNodes, "{way}");
        assert_eq!(
            fault(&none, 10),
            BvhFault::BoxNotListedOnce { id: 9, times: 0 },
            "{way}"
        );
        assert!(matches!(fault(&none, 8), BvhFault::UnknownBox { id: 8, .. }), "{way}");
        for left in [0, 999, u32::MAX] {
            let found = fault(&|tree| tree.nodes[0] = BvhNode::inner(bounds, left), 9);
            assert!(
                matches!(found, BvhFault::ChildOutOfRange { node: 0, .. }),
                "{way}: {found}"
            );
        }
        for (first, count) in [(9, 1), (u32::MAX, u32::MAX), (0, 10)] {
            let found = fault(&|tree| tree.nodes[0] = BvhNode::leaf(bounds, first, count), 9);
            assert!(
                matches!(found, BvhFault::ReferencesOutOfRange { node: 0, .. }),
                "{way}: {found}"
            );
        }
    }
}
