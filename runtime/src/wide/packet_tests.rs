use super::{boxes::WideBoxes, *};
use crate::{
    Aabb, Ray,
    build::{Bvh, BvhSettings, CheckedBoxes, StreamedBvh},
    cluster_frame::SlabRay,
    simd::{Portable, SimdLevel},
    triangle::PreparedRay,
};
use fastrand::Rng;

type Triangle = [[f32; 3]; 3];

const LEVELS: [fn() -> SimdLevel; 2] = [|| SimdLevel::Portable, SimdLevel::detect];

/// Triangles of all sizes, some in planes of axes, some without a place.
fn random_triangles(random: &mut Rng, count: usize, scale: f32) -> Vec<Triangle> {
    let triangle = |_| {
        let mut signed = || random.f32() * 2.0 - 1.0;
        let first: [f32; 3] = std::array::from_fn(|_| signed());
        let mut corners = [first; 3];
        for corner in &mut corners[1..] {
            *corner = std::array::from_fn(|k| first[k] + 0.3 * signed());
        }
        match random.u32(..12) {
            0 => corners.iter_mut().for_each(|corner| corner[1] = first[1]),
            1 => corners[2] = corners[1],
            2 => corners[0][0] = f32::INFINITY,
            _ => {}
        }
        corners.map(|corner| corner.map(|x| x * scale))
    };
    (0..count).map(triangle).collect()
}

/// A camera's rays, or such as no bundle can hold among them.
fn random_rays(random: &mut Rng, triangles: &[Triangle], scale: f32) -> Vec<Ray> {
    let mut signed = || (random.f32() * 2.0 - 1.0) * scale;
    let target: [f32; 3] = std::array::from_fn(|_| signed());
    // Most often outside, where all rays to the triangles run the same way.
    let distance = [0.5, 2.0, 2.0, 2.0][random.usize(..4)] * scale;
    let mut signed = || (random.f32() * 2.0 - 1.0) * scale;
    let eye: [f32; 3] = std::array::from_fn(|_| (signed() + distance).copysign(signed()));
    let spread = [0.0, 0.02, 0.1, 1.0][random.usize(..4)];
    let moved = [0.0, 0.05][random.usize(..2)];
    let length = [1.0, 1e-6, 1e6, 1e-12][random.usize(..4)] / scale;
    let count = [1, 7, 8, 30, 63, 64][random.usize(..6)];
    let ray = |_| {
        let mut near = |reach: f32| (random.f32() * 2.0 - 1.0) * reach * scale;
        let origin: [f32; 3] = std::array::from_fn(|k| eye[k] + near(moved));
        let mut towards: [f32; 3] = std::array::from_fn(|k| target[k] + near(spread));
        let triangle = &triangles[random.usize(..triangles.len())];
        if random.u32(..4) == 0 && triangle.as_flattened().iter().all(|x| x.is_finite()) {
            // Through a corner or the middle of an edge.
            let [a, b] = [triangle[random.usize(..3)], triangle[random.usize(..3)]];
            towards = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        }
        let mut ray = Ray::new(origin, std::array::from_fn(|k| (towards[k] - origin[k]) * length));
        match random.u32(..1000) {
            0 => ray.direction[0] = 0.0,
            1 => ray.direction[1] = f32::NAN,
            2 => ray.t_max = -1.0,
            3 => (ray.t_min, ray.t_max) = (f32::NEG_INFINITY, 0.9 / (length * scale)),
            4 => ray.origin[2] = f32::INFINITY,
            _ => {}
        }
        ray
    };
    (0..count).map(ray).collect()
}

struct World {
    triangles: Vec<Triangle>,
    nodes: Vec<WideNode>,
    bounds: Aabb,
}

fn world(triangles: Vec<Triangle>) -> World {
    let finite = |triangle: &Triangle| triangle.as_flattened().iter().all(|x| x.is_finite());
    let ids: Vec<u32> = (0..)
        .zip(&triangles)
        .filter(|(_, t)| finite(t))
        .map(|(id, _)| id)
        .collect();
    let boxes: Vec<Aabb> = ids.iter().map(|id| Aabb::around(triangles[*id as usize])).collect();
    let mut bvh = Bvh::default();
    StreamedBvh::default().build(CheckedBoxes::new(&boxes).unwrap(), &BvhSettings::default(), &mut bvh);
    let mut nodes = Vec::new();
    collapse(&bvh, &boxes, |place| ids[place as usize], &mut nodes);
    World {
        triangles,
        nodes,
        bounds: bvh.bounds(),
    }
}

type Best = Option<(f32, u32)>;

fn improve(best: &mut Best, t: f32, triangle: u32) -> bool {
    let better = best.is_none_or(|best| (t, triangle) < best);
    if better {
        *best = Some((t, triangle));
    }
    better
}

/// The closest hit of every triangle, one by one.
fn alone(world: &World, ray: &Ray) -> Best {
    let prepared = PreparedRay::new(ray)?;
    let mut best = None;
    for (id, triangle) in (0..).zip(&world.triangles) {
        if let Some(hit) = prepared.intersect(triangle) {
            improve(&mut best, hit.t, id);
        }
    }
    best
}

/// Closest hits, or any for each, through bundles; how many rays were left to go alone.
fn together(level: SimdLevel, world: &World, rays: &[Ray], any: bool) -> (Vec<Best>, usize) {
    let (mut packet, mut stack) = (Packet::new(), WideStack::new());
    let mut best = vec![None; rays.len()];
    let mut left = Vec::new();
    packet.load(level, rays);
    let enter = |bundled: &mut Bundled| {
        let Some(wide) = bundled.in_world(&world.nodes) else {
            left.extend(bundled.groups().flat_map(|group| group * GROUP..(group + 1) * GROUP));
            return;
        };
        let mut visit = |leaf: u32, bundled: &mut Bundled, (): &mut ()| {
            let triangle = &world.triangles[leaf as usize];
            for group in bundled.groups() {
                let mask = bundled.candidates(level, group, triangle);
                for lane in (0..GROUP).filter(|lane| mask >> lane & 1 == 1) {
                    let place = group * GROUP + lane;
                    let ray = PreparedRay::new(&rays[place]).expect("rays of a bundle can hit something");
                    let hit = ray.intersect(triangle);
                    if let Some(hit) = hit
                        && improve(&mut best[place], hit.t, leaf)
                    {
                        bundled.cut(group, lane, if any { f32::NEG_INFINITY } else { hit.t });
                    }
                }
            }
            bundled.is_over()
        };
        walk(
            level,
            &world.nodes,
            0,
            &wide,
            wide.start,
            bundled,
            &mut stack,
            &mut (),
            &mut visit,
        );
    };
    let mut single = Vec::new();
    packet.part(level, &world.nodes[0], &world.bounds, enter, |places| {
        single.extend(places)
    });
    left.extend(single);
    left.retain(|place| *place < rays.len());
    for place in &left {
        best[*place] = alone(world, &rays[*place]);
    }
    (best, left.len())
}

#[test]
fn bundles_hit_what_each_ray_hits_alone() {
    let mut random = Rng::with_seed(31);
    let (mut rays_alone, mut rays_together, mut hits) = (0, 0, 0);
    for round in 0..3000 {
        let scale = [1.0, 1e-15, 1e15][round % 3];
        let count = random.usize(2..80);
        let world = world(random_triangles(&mut random, count, scale));
        let rays = random_rays(&mut random, &world.triangles, scale);
        let expected: Vec<Best> = rays.iter().map(|ray| alone(&world, ray)).collect();
        for level in LEVELS {
            let (found, left) = together(level(), &world, &rays, false);
            assert_eq!(found, expected, "round {round}");
            let (any, _) = together(level(), &world, &rays, true);
            let [any, expected] = [&any, &expected].map(|best| best.iter().map(Option::is_some).collect::<Vec<_>>());
            assert_eq!(any, expected, "round {round}");
            rays_alone += left;
            rays_together += rays.len() - left;
        }
        hits += expected.iter().flatten().count();
    }
    assert!(
        hits > 5000 && rays_together > 40_000 && rays_alone > 20_000,
        "{hits} {rays_together} {rays_alone}"
    );
}

/// Whether a single ray enters the box, with the margin for some bounds.
fn meets_alone(ray: &Ray, bounds: &Aabb, within: &Aabb) -> bool {
    let mut node = WideNode::EMPTY;
    node.set_bounds(0, bounds);
    let wide = WideRay::new(&SlabRay::in_world(ray.origin, ray.direction, within));
    node.meet(Portable, &wide, ray.t_min, ray.t_max).1 & 1 == 1
}

#[test]
fn bundles_visit_what_each_ray_visits_alone() {
    let mut random = Rng::with_seed(32);
    let mut visited = 0;
    for _ in 0..2000 {
        let world = world(random_triangles(&mut random, 60, 1.0));
        let rays = random_rays(&mut random, &world.triangles, 1.0);
        let visits = |level: SimdLevel| {
            let mut packet = Packet::new();
            packet.load(level, &rays);
            let mut out = Vec::new();
            let enter = |bundled: &mut Bundled| {
                let mut leaves = Vec::new();
                let wide = bundled.in_world(&world.nodes).unwrap();
                let mut visit = |leaf: u32, _: &mut Bundled, (): &mut ()| {
                    leaves.push(leaf);
                    false
                };
                let stack = &mut WideStack::new();
                walk(
                    level,
                    &world.nodes,
                    0,
                    &wide,
                    wide.start,
                    bundled,
                    stack,
                    &mut (),
                    &mut visit,
                );
                let boxes = |leaf: u32| Aabb::around(world.triangles[leaf as usize]);
                let meeting = |group: usize| {
                    leaves
                        .iter()
                        .map(|leaf| bundled.meeting(level, group, &boxes(*leaf)))
                        .collect()
                };
                let meeting: Vec<Vec<u32>> = bundled.groups().map(meeting).collect();
                out.push((bundled.groups(), leaves, meeting));
            };
            packet.part(level, &world.nodes[0], &world.bounds, enter, |_| {});
            out
        };
        let found = visits(SimdLevel::detect());
        assert_eq!(found, visits(SimdLevel::Portable));
        for (groups, leaves, meeting) in found {
            for place in groups.start * GROUP..(groups.end * GROUP).min(rays.len()) {
                for (id, triangle) in (0..).zip(&world.triangles) {
                    let bounds = Aabb::around(*triangle);
                    if !world.bounds.contains_box(&bounds) || !meets_alone(&rays[place], &bounds, &world.bounds) {
                        continue;
                    }
                    let at = leaves.iter().position(|leaf| *leaf == id);
                    let at = at.expect("the bundle visits the leaves of each ray");
                    let mask = meeting[place / GROUP - groups.start][at];
                    assert!(mask >> (place % GROUP) & 1 == 1 || !meets_alone(&rays[place], &bounds, &bounds));
                    visited += 1;
                }
            }
        }
    }
    assert!(visited > 10_000, "{visited}");
}

#[test]
fn only_rays_that_look_for_something_count() {
    let mut random = Rng::with_seed(33);
    let world = world(random_triangles(&mut random, 50, 1.0));
    let rays = vec![
        Ray {
            t_min: f32::NEG_INFINITY,
            ..Ray::new([0.1, 0.2, 4.0], [0.1, 0.1, -1.0])
        };
        11
    ];
    let mut packet = Packet::new();
    packet.load(SimdLevel::detect(), &rays);
    let mut bundles = 0;
    let enter = |bundled: &mut Bundled| {
        bundles += 1;
        for level in LEVELS {
            assert_eq!(bundled.meeting(level(), 0, &world.bounds), 0xff);
            assert_eq!(bundled.meeting(level(), 1, &world.bounds), 0b111);
        }
        bundled.cut(0, 0, f32::NEG_INFINITY);
        for level in LEVELS {
            assert_eq!(bundled.meeting(level(), 0, &world.bounds), 0xfe);
        }
        assert!(!bundled.is_over());
        for place in 0..11 {
            bundled.cut(place / GROUP, place % GROUP, f32::NEG_INFINITY);
        }
        assert!(bundled.is_over());
    };
    packet.part(SimdLevel::detect(), &world.nodes[0], &world.bounds, enter, |_| {
        panic!("they are coherent")
    });
    assert_eq!(bundles, 1);
    packet.load(SimdLevel::detect(), &[]);
    packet.part(
        SimdLevel::detect(),
        &world.nodes[0],
        &world.bounds,
        |_| panic!(),
        |_| panic!(),
    );
}
