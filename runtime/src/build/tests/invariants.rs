use super::families::FAMILIES;
use crate::build::{KdBuilder, KdSettings, KdTree, MAX_REFERENCE_GROWTH, sah_cost};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::KdNode;

const SIZES: std::ops::RangeInclusive<usize> = 0..=64;

fn check(name: &str, boxes: &[Aabb], settings: &KdSettings, builder: &mut KdBuilder, tree: &mut KdTree) {
    builder.build(boxes, settings, tree);
    let label = format!("{name}, {} boxes, {settings:?}", boxes.len());
    assert_eq!(tree.validate(boxes), Ok(()), "{label}");
    let present = boxes.iter().filter(|b| !b.is_empty()).count();
    assert!(
        tree.references.len() <= present * MAX_REFERENCE_GROWTH as usize,
        "{label}: {}",
        tree.references.len()
    );
}

#[test]
fn every_family_and_size_gives_a_valid_tree() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let settings = [
        KdSettings::default(),
        KdSettings {
            traversal_cost: 1e-3,
            ..KdSettings::default()
        },
        KdSettings {
            traversal_cost: 20.0,
            empty_bonus: 1.0,
            ..KdSettings::default()
        },
    ];
    for (name, family) in FAMILIES {
        for n in SIZES {
            for seed in 0..3 {
                for settings in &settings {
                    check(name, &family(n, seed), settings, &mut builder, &mut tree);
                }
            }
        }
        for n in [300, 2000] {
            check(name, &family(n, 9), &settings[0], &mut builder, &mut tree);
        }
    }
}

#[test]
fn settings_that_make_no_sense_still_end_in_a_valid_tree() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, f64::MAX];
    for (name, family) in FAMILIES {
        let boxes = family(40, 4);
        for traversal_cost in odd {
            for intersection_cost in odd {
                for empty_bonus in odd {
                    let settings = KdSettings {
                        traversal_cost,
                        intersection_cost,
                        empty_bonus,
                    };
                    check(name, &boxes, &settings, &mut builder, &mut tree);
                }
            }
        }
    }
}

#[test]
fn a_reused_builder_gives_the_bytes_of_a_fresh_one() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    for seed in 0..3 {
        for (name, family) in FAMILIES {
            for n in [700, 3, 64, 0, 1] {
                let boxes = family(n, seed);
                builder.build(&boxes, &KdSettings::default(), &mut tree);
                let mut fresh = KdTree::default();
                KdBuilder::new().build(&boxes, &KdSettings::default(), &mut fresh);
                assert_eq!(tree, fresh, "{name}, {n} boxes, seed {seed}");
            }
        }
    }
}

#[test]
fn a_warm_builder_allocates_nothing() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let sets: Vec<_> = FAMILIES
        .iter()
        .flat_map(|(_, family)| [1000, 20].map(|n| family(n, 1)))
        .collect();
    let mut sweep = |builder: &mut KdBuilder| {
        for boxes in &sets {
            builder.build(boxes, &KdSettings::default(), &mut tree);
        }
        (builder.capacities(), tree.nodes.capacity(), tree.references.capacity())
    };
    let warm = sweep(&mut builder);
    assert_eq!(sweep(&mut builder), warm);
}

#[test]
fn trees_cost_no_more_than_a_leaf() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let settings = KdSettings {
        empty_bonus: 1.0,
        ..KdSettings::default()
    };
    for (name, family) in FAMILIES {
        for n in [1, 10, 500] {
            let boxes = family(n, 2);
            let leaf = settings.intersection_cost * boxes.iter().filter(|b| !b.is_empty()).count() as f64;
            builder.build(&boxes, &settings, &mut tree);
            let cost = sah_cost(&tree.nodes, &tree.bounds, &settings);
            // Each split lowers the cost; only the rounding of sums of up to some thousand terms could raise it.
            assert!(cost <= leaf * (1.0 + 1e-10), "{name}, {n} boxes: {cost} > {leaf}");
        }
    }
}

#[test]
fn separate_small_boxes_end_up_nearly_alone() {
    let boxes = FAMILIES[0].1(2000, 5);
    let mut tree = KdTree::default();
    KdBuilder::new().build(&boxes, &KdSettings::default(), &mut tree);
    let counts = tree.nodes.iter().filter_map(|row| match row.unpack() {
        KdNode::Leaf { count, .. } => Some(count),
        KdNode::Inner { .. } => None,
    });
    let largest = counts.max();
    assert!(largest <= Some(8), "largest leaf {largest:?}");
}
