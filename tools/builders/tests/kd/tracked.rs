//! Tracked kd-trees: valid in every frame whatever the boxes do, near the cost of exact trees, repeatable.

use crate::families::{FAMILIES, furnished, scattered};
use restpose_builders::kd::{KdTreeBuilder, TrackedKd};
use restpose_runtime::Aabb;
use restpose_runtime::build::{CheckedBoxes, KdBuilder, KdSettings, KdTree, MAX_REFERENCE_GROWTH, sah_cost};

fn build(builder: &mut impl KdTreeBuilder, boxes: &[Aabb]) -> KdTree {
    let mut tree = KdTree::default();
    builder.build(CheckedBoxes::new(boxes).unwrap(), &KdSettings::default(), &mut tree);
    tree
}

/// A cloud that swings and breathes: `frame` of 20.
fn moving(frame: usize) -> Vec<Aabb> {
    let phase = frame as f32 / 20.0 * std::f32::consts::TAU;
    let boxes = scattered(20_000, 11, 1.0, 0.05);
    let moved = boxes.iter().map(|b| {
        let shift = 0.2 * (phase + 2.0 * b.min[1]).sin();
        let stretch = 1.0 + 0.1 * phase.cos();
        let place = |[x, y, z]: [f32; 3]| [x + shift, y * stretch, z];
        Aabb::around([place(b.min), place(b.max)])
    });
    moved.collect()
}

#[test]
fn trees_are_valid_whatever_comes_next() {
    for mut builder in [TrackedKd::new(), TrackedKd::paper()] {
        for (name, family) in FAMILIES {
            for n in (1..=60).chain([64, 65, 127, 300, 3000, 2000, 10]) {
                let boxes = family(n, n as u64);
                let tree = build(&mut builder, &boxes);
                assert_eq!(tree.validate(&boxes), Ok(()), "{name}, {n} boxes");
                assert!(
                    tree.references.len() <= n * MAX_REFERENCE_GROWTH as usize,
                    "{name}, {n} boxes"
                );
            }
        }
    }
}

#[test]
fn settings_that_make_no_sense_still_end_in_a_valid_tree() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, f64::MAX];
    let mut builder = TrackedKd::paper();
    for (name, family) in FAMILIES {
        let boxes = family(150, 4);
        for traversal_cost in odd {
            for intersection_cost in odd {
                let settings = KdSettings {
                    traversal_cost,
                    intersection_cost,
                    ..KdSettings::default()
                };
                let mut tree = KdTree::default();
                builder.build(CheckedBoxes::new(&boxes).unwrap(), &settings, &mut tree);
                assert_eq!(tree.validate(&boxes), Ok(()), "{name}, {settings:?}");
            }
        }
    }
}

#[test]
fn moving_boxes_are_tracked_at_little_loss() {
    let settings = KdSettings::default();
    for mut builder in [TrackedKd::new(), TrackedKd::paper()] {
        for frame in 0..20 {
            let boxes = moving(frame);
            let tree = build(&mut builder, &boxes);
            assert_eq!(tree.validate(&boxes), Ok(()), "frame {frame}");
            let exact = build(&mut KdBuilder::new(), &boxes);
            let quality =
                sah_cost(&exact.nodes, &exact.bounds, &settings) / sah_cost(&tree.nodes, &tree.bounds, &settings);
            assert!(quality >= 0.95, "frame {frame}: {quality}");
            let stats = builder.stats();
            if frame > 0 {
                assert!(stats.tracked_share() > 0.2, "frame {frame}: {stats:?}");
                // Twelve evaluations end any search, and five-hundredths of a length any window.
                assert!(
                    stats.steps_per_tracked_node() <= 12.0 && stats.prediction_error() < 0.05,
                    "{stats:?}"
                );
            }
        }
    }
}

#[test]
fn leaves_lose_little_where_boxes_are_very_uneven() {
    let settings = KdSettings::default();
    let mut builder = TrackedKd::new();
    for frame in 0..6 {
        let swing = |x: f32, y: f32| x + 0.05 * (frame as f32 + 2.0 * y).sin();
        let mut boxes = furnished();
        for own in &mut boxes {
            let y = own.min[1];
            (own.min[0], own.max[0]) = (swing(own.min[0], y), swing(own.max[0], y));
        }
        let (tree, exact) = (build(&mut builder, &boxes), build(&mut KdBuilder::new(), &boxes));
        let [most, nodes] = [exact.nodes.len(), tree.nodes.len()];
        let [exact, cost] = [exact, tree].map(|tree| sah_cost(&tree.nodes, &tree.bounds, &settings));
        assert!(exact / cost > 0.97, "frame {frame}: {exact} against {cost}");
        // From the second frame on the builder knows what leaves weigh.
        assert!(
            frame == 0 || 3 * nodes < 2 * most,
            "frame {frame}: {nodes} of {most} nodes"
        );
    }
}

#[test]
fn what_rests_is_tracked_and_forgetting_starts_anew() {
    let boxes = scattered(5000, 3, 1.0, 0.05);
    let mut builder = TrackedKd::new();
    let first = build(&mut builder, &boxes);
    assert_eq!(builder.stats().tracked_nodes, 0);
    build(&mut builder, &boxes);
    assert!(builder.stats().tracked_share() > 0.6, "{:?}", builder.stats());
    builder.forget();
    assert!(build(&mut builder, &boxes) == first);
    assert_eq!(builder.stats().tracked_nodes, 0);
}
