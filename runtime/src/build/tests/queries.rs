use super::families::FAMILIES;
use super::random::Random;
use crate::build::{KdBuilder, KdSettings, KdTree};
use restpose_formats::geom::Aabb;
use restpose_formats::rows::KdNode;

/// Boxes that a walk finds which enters every child whose closed cell `meets` says yes to.
fn found(tree: &KdTree, meets: impl Fn(&Aabb) -> bool) -> Vec<u32> {
    let mut ids = Vec::new();
    let mut open = vec![(0, tree.bounds)];
    while let Some((node, cell)) = open.pop() {
        if !meets(&cell) {
            continue;
        }
        match tree.nodes[node].unpack() {
            KdNode::Leaf { first, count } => {
                ids.extend_from_slice(&tree.references[first as usize..(first + count) as usize]);
            }
            KdNode::Inner { axis, split, left } => {
                let (mut lower, mut upper) = (cell, cell);
                lower.max[axis] = split;
                upper.min[axis] = split;
                open.extend([(left as usize, lower), (left as usize + 1, upper)]);
            }
        }
    }
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// A number that points and boxes often share: a side of some box, or something between.
fn coordinate(boxes: &[Aabb], axis: usize, random: &mut Random) -> f32 {
    let bounds = boxes[random.below(boxes.len())];
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    let x = match random.below(4) {
        0 => min,
        1 => max,
        2 => 0.5 * min + 0.5 * max,
        _ => min + random.unit() * (max - min),
    };
    if x.is_finite() { x } else { 1.0 }
}

#[test]
fn points_find_every_box_around_them() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let mut hits = 0;
    for (name, family) in FAMILIES {
        for n in [1, 7, 60] {
            let boxes = family(n, 3);
            builder.build(&boxes, &KdSettings::default(), &mut tree);
            let mut random = Random::new(n as u64);
            for _ in 0..400 {
                let point: [f32; 3] = std::array::from_fn(|k| coordinate(&boxes, k, &mut random));
                let ids = found(&tree, |cell| cell.contains(point));
                for (id, bounds) in boxes.iter().enumerate().filter(|(_, b)| b.contains(point)) {
                    hits += 1;
                    assert!(
                        ids.contains(&(id as u32)),
                        "{name}, {n} boxes: {point:?} misses {id} {bounds:?}"
                    );
                }
            }
        }
    }
    assert!(hits > 10_000, "only {hits} boxes were hit");
}

/// True when the closed segment from `a` to `b` meets the closed box; exact for integers below 2²⁰.
fn segment_meets(a: [i64; 3], b: [i64; 3], bounds: &Aabb) -> bool {
    // Parameters as fractions with positive denominators.
    let (mut enter, mut leave) = ((0i64, 1i64), (1i64, 1i64));
    for k in 0..3 {
        let (lo, hi) = (bounds.min[k] as i64, bounds.max[k] as i64);
        let d = b[k] - a[k];
        if d == 0 {
            if a[k] < lo || a[k] > hi {
                return false;
            }
            continue;
        }
        let (near, far) = if d > 0 {
            (lo - a[k], hi - a[k])
        } else {
            (a[k] - hi, a[k] - lo)
        };
        let d = d.abs();
        if near * enter.1 > enter.0 * d {
            enter = (near, d);
        }
        if far * leave.1 < leave.0 * d {
            leave = (far, d);
        }
    }
    enter.0 * leave.1 <= leave.0 * enter.1
}

#[test]
fn segments_find_every_box_they_meet() {
    let (mut builder, mut tree) = (KdBuilder::new(), KdTree::default());
    let mut hits = 0;
    for (name, family) in FAMILIES {
        for n in [5, 64] {
            // Whole numbers, so that the oracle is exact; many sides fall together.
            let boxes: Vec<Aabb> = family(n, 6)
                .iter()
                .filter(|b| !b.is_empty())
                .map(|b| {
                    let whole = |x: f32| {
                        if x.is_nan() {
                            0.0
                        } else {
                            (x.clamp(-50.0, 50.0) * 3.0).round()
                        }
                    };
                    Aabb::around([b.min.map(whole), b.max.map(whole)])
                })
                .collect();
            builder.build(&boxes, &KdSettings::default(), &mut tree);
            assert_eq!(tree.validate(&boxes), Ok(()));
            let mut random = Random::new(n as u64);
            for _ in 0..200 {
                let mut end =
                    || -> [i64; 3] { std::array::from_fn(|k| coordinate(&boxes, k, &mut random).round() as i64) };
                let (a, b) = (end(), end());
                let ids = found(&tree, |cell| segment_meets(a, b, cell));
                for (id, bounds) in boxes.iter().enumerate().filter(|(_, x)| segment_meets(a, b, x)) {
                    hits += 1;
                    assert!(
                        ids.contains(&(id as u32)),
                        "{name}, {n} boxes: {a:?} to {b:?} misses {id} {bounds:?}"
                    );
                }
            }
        }
    }
    assert!(hits > 10_000, "only {hits} boxes were met");
}
