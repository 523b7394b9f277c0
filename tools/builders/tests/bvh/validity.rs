use super::builders::{Entry, all_bvh_builders};
use super::families::FAMILIES;
use super::tree_sets::built;
use restpose_builders::bvh::BvhBuilder;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{BuildError, Bvh, BvhSettings, CheckedBoxes};

const DEEP: BvhSettings = BvhSettings {
    traversal_cost: 1e-3,
    intersection_cost: 1.0,
};

fn check(entry: &Entry, builder: &mut dyn BvhBuilder, name: &str, boxes: &[Aabb], settings: &BvhSettings) {
    let tree = built(builder, boxes, settings);
    let label = format!("{}, {name}, {} boxes, {settings:?}", entry.name, boxes.len());
    assert_eq!(tree.validate(boxes), Ok(()), "{label}");
    if entry.by_cost {
        let (cost, leaf) = (tree.sah_cost(settings), settings.intersection_cost * boxes.len() as f64);
        // A builder may take a split that is dearer than a leaf by the rounding of its costs, stated as 2⁻²⁰ at most;
        // the sum of such errors over a level is at most that of the leaf, and there are 64 levels.
        assert!(
            cost <= leaf * (1.0 + 64.0 * f64::exp2(-20.0)),
            "{label}: {cost} > {leaf}"
        );
    }
}

#[test]
fn every_builder_ends_in_a_valid_tree_on_every_family() {
    for entry in all_bvh_builders() {
        let mut builder = (entry.make)();
        for (name, family) in FAMILIES {
            for n in 1..=100 {
                for settings in [BvhSettings::default(), DEEP] {
                    check(&entry, &mut *builder, name, &family(n, n as u64), &settings);
                }
            }
            check(&entry, &mut *builder, name, &family(20_000, 7), &BvhSettings::default());
            check(&entry, &mut *builder, name, &family(5_000, 8), &DEEP);
        }
    }
}

#[test]
fn settings_that_make_no_sense_still_end_in_a_valid_tree() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, f64::MAX];
    for entry in all_bvh_builders() {
        let mut builder = (entry.make)();
        for (name, family) in FAMILIES {
            let boxes = family(60, 4);
            for traversal_cost in odd {
                for intersection_cost in odd {
                    let settings = BvhSettings {
                        traversal_cost,
                        intersection_cost,
                    };
                    let tree = built(&mut *builder, &boxes, &settings);
                    assert_eq!(tree.validate(&boxes), Ok(()), "{}, {name}, {settings:?}", entry.name);
                }
            }
        }
    }
}

#[test]
fn a_tree_that_held_another_is_replaced() {
    for entry in all_bvh_builders() {
        let mut builder = (entry.make)();
        let mut tree = Bvh::default();
        for (name, family) in FAMILIES {
            for n in [700, 3, 64, 1] {
                let boxes = family(n, 5);
                builder.build(CheckedBoxes::new(&boxes).unwrap(), &BvhSettings::default(), &mut tree);
                let fresh = built(&mut *(entry.make)(), &boxes, &BvhSettings::default());
                assert_eq!(tree, fresh, "{}, {name}, {n} boxes", entry.name);
            }
        }
    }
}

#[test]
fn no_boxes_and_boxes_without_numbers_are_refused_before_any_builder() {
    for (_, family) in FAMILIES {
        assert_eq!(CheckedBoxes::new(&family(0, 1)).unwrap_err(), BuildError::NoBoxes);
        let mut boxes = family(9, 1);
        boxes[4].max[2] = f32::NAN;
        let error = CheckedBoxes::new(&boxes).unwrap_err();
        assert!(
            matches!(error, BuildError::NotFinite { index: 4, axis: 2, .. }),
            "{error}"
        );
    }
}

#[test]
fn separate_small_boxes_end_up_nearly_alone() {
    let boxes = FAMILIES[0].1(3000, 5);
    for entry in all_bvh_builders() {
        let tree = built(&mut *(entry.make)(), &boxes, &BvhSettings::default());
        let leaves = tree.nodes.len().div_ceil(2);
        assert!(leaves > boxes.len() / 3, "{}: {leaves} leaves", entry.name);
    }
}
