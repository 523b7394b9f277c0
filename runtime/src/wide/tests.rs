use super::{boxes::WideBoxes, *};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb,
    build::{Bvh, BvhSettings, CheckedBoxes, StreamedBvh},
    cluster_frame::{LatticeRay, SlabRay},
    mover_maps::MoverMaps,
    simd::{Lanes, Portable, SimdLevel},
};
use fastrand::Rng;
use restpose_formats::rows::{ReferenceBoxRow, WideChild, WideNodeRow, box_steps};

/// What is visited below a node, in order. With `cut`, visits shorten the ray.
pub(super) fn visits_below<N: WideBoxes<R>, R>(
    level: SimdLevel,
    nodes: &[N],
    root: u32,
    ray: &R,
    (start, limit): (f32, f32),
    cut: Option<&dyn Fn(u32) -> f32>,
) -> Vec<u32> {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        return visits_with(simd, nodes, root, ray, (start, limit), cut);
    }
    visits_with(Portable, nodes, root, ray, (start, limit), cut)
}

fn visits_with<S: Lanes, N: WideBoxes<R>, R>(
    simd: S,
    nodes: &[N],
    root: u32,
    ray: &R,
    (start, limit): (f32, f32),
    cut: Option<&dyn Fn(u32) -> f32>,
) -> Vec<u32> {
    let mut out = Vec::new();
    let (mut stack, mut count, mut node) = (WideStack::new(), 0, Some(root));
    let mut way = Descent {
        start,
        limit,
        floor: 0,
        // Every other tree is far: to stop at nodes changes nothing.
        is_far: nodes.len().is_multiple_of(2),
    };
    while let Some(child) = way.next(simd, nodes, ray, node, &mut stack, &mut count, &mut ()) {
        node = match WideChild::unpack(child) {
            WideChild::Node(node) => Some(node),
            WideChild::Leaf(leaf) => {
                out.push(leaf);
                if let Some(cut) = cut {
                    way.limit = way.limit.min(cut(leaf));
                }
                None
            }
            WideChild::Empty => unreachable!("no child is empty"),
        };
    }
    out
}

fn random_boxes(random: &mut Rng, count: usize, scale: f32) -> Vec<Aabb> {
    let boxes = (0..count).map(|_| {
        let size = scale * [0.0, 0.02, 0.02, 0.3][random.usize(..4)];
        let min: [f32; 3] = std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * scale);
        let max = std::array::from_fn(|k| min[k] + random.f32() * size);
        Aabb { min, max }
    });
    let mut boxes: Vec<Aabb> = boxes.collect();
    // Coincident ones, which end in one leaf.
    for at in 0..count / 8 {
        boxes[at] = boxes[0];
    }
    boxes
}

fn tree(boxes: &[Aabb]) -> Vec<WideNode> {
    let mut bvh = Bvh::default();
    if let Ok(checked) = CheckedBoxes::new(boxes) {
        StreamedBvh::default().build(checked, &BvhSettings::default(), &mut bvh);
    }
    let mut nodes = Vec::new();
    collapse(&bvh, boxes, |reference| reference, &mut nodes);
    nodes
}

fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |union, bounds| union.union(*bounds))
}

/// Origin and direction: along axes, in the planes of boxes, from the corner of one to that of another, or anyhow.
fn random_ray(random: &mut Rng, boxes: &[Aabb], scale: f32) -> ([f32; 3], [f32; 3]) {
    let mut signed = || random.f32() * 2.0 - 1.0;
    let mut origin: [f32; 3] = std::array::from_fn(|_| signed() * 2.0 * scale);
    let mut direction: [f32; 3] = std::array::from_fn(|_| signed());
    let a = boxes[random.usize(..boxes.len())];
    let b = boxes[random.usize(..boxes.len())];
    match random.u32(..6) {
        0 => direction = std::array::from_fn(|k| (b.max[k] - origin[k]) / scale),
        1 => (origin, direction) = (a.min, std::array::from_fn(|k| (b.min[k] - a.min[k]) / scale)),
        2 => {
            let plane = random.usize(..3);
            origin[plane] = a.min[plane];
            direction = std::array::from_fn(|k| (a.center()[k] - origin[k]) / scale);
            direction[plane] = [0.0, -0.0][random.usize(..2)];
        }
        3 => {
            origin = a.max;
            direction = [[0.0; 3], [-0.0; 3]][random.usize(..2)];
            direction[random.usize(..3)] = [1.0, -1.0][random.usize(..2)];
        }
        _ => {}
    }
    if direction.iter().all(|x| *x == 0.0) {
        direction[0] = 1.0;
    }
    (origin, direction)
}

/// Whether the exact ray meets the box, but for the rounding of `f64`.
fn certainly_meets(origin: [f32; 3], direction: [f32; 3], bounds: &Aabb, (start, limit): (f32, f32)) -> bool {
    let (mut enter, mut exit) = (f64::from(start), f64::from(limit));
    for k in 0..3 {
        let [o, d] = [origin[k], direction[k]].map(f64::from);
        let [min, max] = [bounds.min[k], bounds.max[k]].map(f64::from);
        if d == 0.0 {
            if o < min || o > max {
                return false;
            }
            continue;
        }
        let (a, b) = ((min - o) / d, (max - o) / d);
        enter = enter.max(a.min(b));
        exit = exit.min(a.max(b));
    }
    enter <= exit
}

/// The same from the first node on.
fn visits<N: WideBoxes<R>, R>(
    level: SimdLevel,
    nodes: &[N],
    ray: &R,
    range: (f32, f32),
    cut: Option<&dyn Fn(u32) -> f32>,
) -> Vec<u32> {
    visits_below(level, nodes, 0, ray, range, cut)
}

const RANGES: [(f32, f32); 4] = [
    (0.0, f32::INFINITY),
    (f32::NEG_INFINITY, f32::INFINITY),
    (0.0, f32::MAX),
    (-1.0, 0.5),
];

#[test]
fn every_leaf_that_the_ray_meets_is_visited_once_at_every_level() {
    let mut random = Rng::with_seed(11);
    for round in 0..600 {
        let count = [1, 2, 7, 8, 9, 60, 400][round % 7];
        let scale = [1.0, 1e-30, 1e30, 1e-38, 1e38][round / 7 % 5];
        let boxes = random_boxes(&mut random, count, scale);
        let nodes = tree(&boxes);
        for _ in 0..40 {
            let (origin, direction) = random_ray(&mut random, &boxes, scale);
            let range = RANGES[random.usize(..RANGES.len())];
            let ray = WideRay::new(&SlabRay::in_world(origin, direction, &around(&boxes)));
            let met = visits(SimdLevel::Portable, &nodes, &ray, range, None);
            assert_eq!(met, visits(SimdLevel::detect(), &nodes, &ray, range, None));
            let mut times = vec![0; boxes.len()];
            met.iter().for_each(|leaf| times[*leaf as usize] += 1);
            for (leaf, bounds) in boxes.iter().enumerate() {
                assert!(times[leaf] <= 1);
                let expected = certainly_meets(origin, direction, bounds, range);
                assert!(
                    times[leaf] == 1 || !expected,
                    "{origin:?} {direction:?} {bounds:?} {range:?} {ray:?}"
                );
            }
        }
    }
}

#[test]
fn of_boxes_entered_at_once_the_first_is_visited_first() {
    let mut node = WideNode::EMPTY;
    for (place, start) in [5.0, 3.0, 5.0, 3.0, 4.0, 3.0].into_iter().enumerate() {
        node.children[place] = WideChild::Leaf(place as u32).pack();
        node.set_bounds(
            place,
            &Aabb {
                min: [start, -1.0, -1.0],
                max: [9.0, 1.0, 1.0],
            },
        );
    }
    let ray = WideRay::new(&SlabRay::in_world([0.0; 3], [1.0, 0.0, 0.0], &node.around()));
    for level in [SimdLevel::Portable, SimdLevel::detect()] {
        assert_eq!(
            visits(level, &[node], &ray, (0.0, f32::INFINITY), None),
            [1, 3, 5, 4, 0, 2]
        );
    }
}

#[test]
fn margins_are_folded_in_outwards() {
    let mut random = Rng::with_seed(12);
    for round in 0..200_000 {
        let scale = [1.0, 1e-20, 1e20, 1e-37][round % 4];
        let boxes = random_boxes(&mut random, 1, scale);
        let (origin, direction) = random_ray(&mut random, &boxes, scale);
        let slab = SlabRay::in_world(origin, direction, &boxes[0]);
        let wide = WideRay::new(&slab);
        for k in 0..3 {
            let [o, m] = [slab.origin[k], slab.margin[k]].map(f64::from);
            let [above, below] = if wide.near_row[k] == 0 {
                [wide.near[k], wide.far[k]]
            } else {
                [wide.far[k], wide.near[k]]
            };
            // The part of the margin that is spared for its own rounding, and more.
            let m = m * (1.0 - 1.0 / 1024.0);
            assert!(f64::from(above) >= o + m && f64::from(below) <= o - m, "{slab:?}");
            let far = m + 16.0 * restpose_formats::geom::round::UNIT_ROUNDOFF * (o.abs() + m) + m / 512.0;
            assert!(f64::from(above) <= o + far && f64::from(below) >= o - far, "{slab:?}");
        }
    }
}

#[test]
fn cut_rays_visit_the_same_in_the_same_order_at_every_level() {
    let mut random = Rng::with_seed(13);
    let mut skipped = 0;
    for round in 0..2000 {
        let boxes = random_boxes(&mut random, 200, 1.0);
        let nodes = tree(&boxes);
        let (origin, direction) = random_ray(&mut random, &boxes, 1.0);
        let ray = WideRay::new(&SlabRay::in_world(origin, direction, &around(&boxes)));
        let ends: Vec<f32> = boxes.iter().map(|_| random.f32() * 4.0).collect();
        let cut = |leaf: u32| ends[leaf as usize];
        let [all, met, other] = [
            (SimdLevel::Portable, None),
            (SimdLevel::Portable, Some(&cut as &dyn Fn(u32) -> f32)),
            (SimdLevel::detect(), Some(&cut)),
        ]
        .map(|(level, cut)| visits(level, &nodes, &ray, (0.0, f32::INFINITY), cut));
        assert_eq!(met, other, "round {round}");
        skipped += all.len() - met.len();
        // What was passed over begins behind the least end; what was visited began before it.
        let mut limit = f32::INFINITY;
        for leaf in &met {
            assert!(certainly_meets_nearly(origin, direction, &boxes[*leaf as usize], limit));
            limit = limit.min(cut(*leaf));
        }
        for leaf in all.iter().filter(|leaf| !met.contains(leaf)) {
            assert!(!certainly_meets(
                origin,
                direction,
                &boxes[*leaf as usize],
                (0.0, limit)
            ));
        }
    }
    assert!(skipped > 1000, "{skipped}");
}

/// With boxes and limit larger by what margins may add.
fn certainly_meets_nearly(origin: [f32; 3], direction: [f32; 3], bounds: &Aabb, limit: f32) -> bool {
    let bounds = Aabb {
        min: bounds.min.map(|x| x - 1e-4),
        max: bounds.max.map(|x| x + 1e-4),
    };
    certainly_meets(origin, direction, &bounds, (0.0, limit))
}

/// A ray for nodes without movers.
fn fuzzy_ray(ray: LatticeRay) -> FuzzyRay<'static> {
    FuzzyRay {
        boxes: FuzzyBoxes {
            keys: None,
            motions: &MoverMaps::NONE,
            movers: &[],
        },
        fuzzy: ray,
        posed: ray,
    }
}

/// The same tree on the lattice of its bounds.
fn on_lattice(nodes: &[WideNode], bounds: &Aabb) -> Vec<WideNodeRow> {
    let row = |node: &WideNode| {
        let mut out = WideNodeRow {
            children: node.children,
            ..WideNodeRow::EMPTY
        };
        for place in (0..8).filter(|place| node.children[*place] != WideChild::EMPTY) {
            let on_lattice = ReferenceBoxRow::around(&node.bounds(place), bounds);
            for k in 0..3 {
                (out.min[k][place], out.max[k][place]) = (on_lattice.min[k], on_lattice.max[k]);
            }
        }
        out
    };
    nodes.iter().map(row).collect()
}

#[test]
fn rows_are_entered_as_their_boxes_one_by_one() {
    let mut random = Rng::with_seed(14);
    for round in 0..700 {
        let scale = [1.0, 1e-30, 1e30][round % 3];
        let boxes = random_boxes(&mut random, [1, 5, 8, 100][round % 4], scale);
        let bounds = around(&boxes);
        let rows = on_lattice(&tree(&boxes), &bounds);
        for _ in 0..20 {
            let (origin, direction) = random_ray(&mut random, &boxes, scale);
            let range = RANGES[random.usize(..RANGES.len())];
            let mut slab = SlabRay::in_world(origin, direction, &bounds);
            if random.u32(..8) == 0 {
                slab.margin[random.usize(..3)] = f32::INFINITY;
            }
            let ray = LatticeRay::new(&slab, &bounds, &box_steps(&bounds));
            let fuzzy = fuzzy_ray(ray);
            let mut met = visits(SimdLevel::Portable, &rows, &fuzzy, range, None);
            assert_eq!(met, visits(SimdLevel::detect(), &rows, &fuzzy, range, None));
            met.sort_unstable();
            let alone = (0u32..).zip(&boxes);
            let alone = alone.filter(|(_, fuzzy)| ray.meets(&ReferenceBoxRow::around(fuzzy, &bounds), range));
            assert_eq!(met, alone.map(|(leaf, _)| leaf).collect::<Vec<u32>>(), "{ray:?}");
        }
    }
}

#[test]
fn empty_places_are_not_entered_by_rays_that_nothing_restricts() {
    let mut random = Rng::with_seed(15);
    let boxes = random_boxes(&mut random, 43, 1.0);
    let mut nodes = tree(&boxes);
    refit(&mut nodes, |leaf| {
        if leaf % 3 == 0 {
            Aabb::EMPTY
        } else {
            boxes[leaf as usize]
        }
    });
    let slab = SlabRay::in_world(
        [f32::MAX; 3],
        [-1.0; 3],
        &Aabb {
            min: [f32::MIN; 3],
            max: [1.0; 3],
        },
    );
    let ray = WideRay::new(&slab);
    assert!(ray.unbounded, "the distance overflows");
    for level in [SimdLevel::Portable, SimdLevel::detect()] {
        let mut met = visits(level, &nodes, &ray, (0.0, f32::INFINITY), None);
        met.sort_unstable();
        assert_eq!(met, (0..43).filter(|leaf| leaf % 3 != 0).collect::<Vec<u32>>());
        assert_eq!(visits(level, &[WideNode::EMPTY], &ray, (0.0, f32::INFINITY), None), []);
        let nothing = LatticeRay {
            rate: [f32::NAN; 3],
            near: [0.0; 3],
            far: [0.0; 3],
            forward: [true; 3],
        };
        assert_eq!(
            visits(
                level,
                &[WideNodeRow::EMPTY],
                &fuzzy_ray(nothing),
                (0.0, f32::INFINITY),
                None
            ),
            []
        );
    }
}
