use super::{ray_bundle::lengthened, ray_group::RayGroup, *};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Ray,
    build::{Bvh, BvhSettings, CheckedBoxes, StreamedBvh},
    cluster_frame::SlabRay,
    set_bits::set_bits,
    simd::{Lanes, Portable, SimdLevel},
    triangle::{PreparedRay, TriangleHit},
    wide::{WideBoxes, WideNode, WideRay, WideStack, collapse, tests::visits_below},
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
    // Now and then all of them are nearly parallel to a plane, or to an axis.
    let flat: [bool; 3] = match random.u32(..4) {
        0 => std::array::from_fn(|_| random.bool()),
        _ => [false; 3],
    };
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
        for k in (0..3).filter(|k| flat[*k]) {
            ray.direction[k] = [0.0, -0.0, 1e-20, -1e-20][random.usize(..4)] * length;
        }
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

/// The leaves below a node that a ray meets.
fn leaves_below(level: SimdLevel, world: &World, node: u32, ray: &Ray) -> Vec<u32> {
    let wide = WideRay::new(&SlabRay::in_world(ray.origin, ray.direction, &world.bounds));
    visits_below(level, &world.nodes, node, &wide, (f32::MIN, f32::INFINITY), None)
}

/// How rays came to their hits.
#[derive(Clone, Copy, Debug, Default)]
struct Ways {
    /// Rays that no bundle took, and those that one did.
    single: usize,
    bundled: usize,
    /// Rays that left their bundle on the way.
    parted: usize,
}

/// Closest hits, or any for each, through bundles.
fn together(level: SimdLevel, world: &World, rays: &[Ray], any: bool, ways: &mut Ways) -> Vec<Best> {
    let (mut packet, mut stack) = (Packet::new(), WideStack::new());
    let mut best = vec![None; rays.len()];
    let mut left = Vec::new();
    let end = |t: f32| if any { f32::NEG_INFINITY } else { t };
    let mut hits = [GroupHits::NONE; PACKET / GROUP];
    let enter = |bundled: &mut Bundled| {
        let places = bundled.places();
        let Some(together) = bundled.in_world(&world.nodes) else {
            left.extend(set_bits(places));
            return;
        };
        let mut visit = |part: Part, bundled: &mut Bundled| {
            let mut cut = |bundled: &mut Bundled, place: usize, t: f32, triangle: u32| {
                if improve(&mut best[place], t, triangle) {
                    bundled.cut(place, end(t));
                }
            };
            match part {
                Part::Leaf { leaf, groups } => {
                    let found = bundled.hits(level, groups, &world.triangles[leaf as usize], &mut hits);
                    for place in set_bits(found) {
                        cut(bundled, place, hits[place / GROUP].t[place % GROUP], leaf);
                    }
                    bundled.shorten(level, groups);
                }
                Part::Alone { node, places } => {
                    for place in set_bits(places) {
                        ways.parted += 1;
                        let ray = PreparedRay::new(&rays[place]).expect("rays of a bundle can hit something");
                        for leaf in leaves_below(level, world, node, &rays[place]) {
                            if let Some(hit) = ray.intersect(&world.triangles[leaf as usize]) {
                                cut(bundled, place, hit.t, leaf);
                            }
                        }
                    }
                    bundled.shorten(level, 0xff);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut &world.nodes[..], &together, bundled, &mut stack, &mut visit);
    };
    let mut single = Vec::new();
    packet.part(level, rays, &world.nodes[0], &world.bounds, enter, |places| {
        single.extend(places)
    });
    left.extend(single);
    for place in &left {
        best[*place] = alone(world, &rays[*place]);
    }
    ways.single += left.len();
    ways.bundled += rays.len() - left.len();
    best
}

#[test]
fn bundles_hit_what_each_ray_hits_alone() {
    let mut random = Rng::with_seed(31);
    let (mut ways, mut hits) = (Ways::default(), 0);
    for round in 0..3000 {
        let scale = [1.0, 1e-15, 1e15][round % 3];
        // Now and then as many as make bundles part.
        let count = random.usize(4..if round % 10 == 0 { 800 } else { 80 });
        let world = world(random_triangles(&mut random, count, scale));
        let rays = random_rays(&mut random, &world.triangles, scale);
        let expected: Vec<Best> = rays.iter().map(|ray| alone(&world, ray)).collect();
        for level in LEVELS {
            let found = together(level(), &world, &rays, false, &mut ways);
            assert_eq!(found, expected, "round {round}");
            let any = together(level(), &world, &rays, true, &mut ways);
            let [any, expected] = [&any, &expected].map(|best| best.iter().map(Option::is_some).collect::<Vec<_>>());
            assert_eq!(any, expected, "round {round}");
        }
        hits += expected.iter().flatten().count();
    }
    assert!(
        hits > 5000 && ways.bundled > 80_000 && ways.single > 40_000 && ways.parted > 10_000,
        "{hits} {ways:?}"
    );
}

/// Whether a single ray enters the box, with the margin for some bounds.
fn meets_alone(ray: &Ray, bounds: &Aabb, within: &Aabb) -> bool {
    let mut node = WideNode::EMPTY;
    node.set_bounds(0, bounds);
    let wide = WideRay::new(&SlabRay::in_world(ray.origin, ray.direction, within));
    let [enter, exit] = node.meet(Portable, 0, &wide, ray.t_min, ray.t_max);
    enter[0] <= exit[0]
}

/// The way of a bundle: its rays, each leaf with the groups that came there and those of its rays that may be in its box,
/// and each ray that went on alone, with the leaves that it could meet.
#[derive(Debug, PartialEq)]
struct Visits {
    places: u64,
    leaves: Vec<(u32, u32, u64)>,
    alone: Vec<(usize, Vec<u32>)>,
}

#[test]
fn bundles_visit_what_each_ray_visits_alone() {
    let mut random = Rng::with_seed(32);
    let mut visited = [0, 0];
    for round in 0..2000 {
        let world = world(random_triangles(
            &mut random,
            if round % 10 == 0 { 600 } else { 60 },
            1.0,
        ));
        let rays = random_rays(&mut random, &world.triangles, 1.0);
        let boxes = |leaf: u32| Aabb::around(world.triangles[leaf as usize]);
        let visits = |level: SimdLevel| {
            let mut out = Vec::new();
            let enter = |bundled: &mut Bundled| {
                let (mut leaves, mut alone) = (Vec::new(), Vec::new());
                let Some(together) = bundled.in_world(&world.nodes) else {
                    return;
                };
                let mut visit = |part: Part, bundled: &mut Bundled| {
                    match part {
                        Part::Leaf { leaf, groups } => {
                            leaves.push((leaf, groups, bundled.meeting(level, 0xff, &boxes(leaf))));
                        }
                        Part::Alone { node, places } => {
                            let below = |place| (place, leaves_below(level, &world, node, &rays[place]));
                            alone.extend(set_bits(places).map(below));
                        }
                    }
                    false
                };
                walk_together(
                    level,
                    &mut &world.nodes[..],
                    &together,
                    bundled,
                    &mut WideStack::new(),
                    &mut visit,
                );
                out.push(Visits {
                    places: bundled.places(),
                    leaves,
                    alone,
                });
            };
            let mut packet = Packet::new();
            packet.part(level, &rays, &world.nodes[0], &world.bounds, enter, |_| {});
            out
        };
        let found = visits(SimdLevel::detect());
        assert_eq!(found, visits(SimdLevel::Portable));
        for bundle in found {
            for place in set_bits(bundle.places) {
                for (id, triangle) in (0..).zip(&world.triangles) {
                    let bounds = Aabb::around(*triangle);
                    if !world.bounds.contains_box(&bounds) || !meets_alone(&rays[place], &bounds, &world.bounds) {
                        continue;
                    }
                    // Those count as a little turned: only what they hit is certain.
                    if rays[place].direction.iter().any(|d| lengthened(*d) != *d) {
                        continue;
                    }
                    let with_others = bundle.leaves.iter().find(|(leaf, ..)| *leaf == id);
                    if let Some((_, _, meeting)) =
                        with_others.filter(|(_, groups, _)| groups >> (place / GROUP) & 1 == 1)
                    {
                        assert!(meeting >> place & 1 == 1 || !meets_alone(&rays[place], &bounds, &bounds));
                        visited[0] += 1;
                    } else {
                        let mut alone = bundle.alone.iter().filter(|(own, _)| *own == place);
                        assert!(
                            alone.any(|(_, leaves)| leaves.contains(&id)),
                            "the bundle or the ray visits the leaf"
                        );
                        visited[1] += 1;
                    }
                }
            }
        }
    }
    assert!(visited[0] > 10_000 && visited[1] > 2_000, "{visited:?}");
}

/// Where a triangle's corners, edges and planes are hit, where ranges end, where directions change their longest axis.
#[test]
fn eight_rays_hit_what_each_of_them_hits() {
    let mut random = Rng::with_seed(34);
    let (mut hits, mut ends) = (0, 0);
    for round in 0..25_000 {
        let scale = [1.0, 1e-15, 1e15, 1e-30, 1e30][round % 5];
        let triangles = random_triangles(&mut random, 4, scale);
        let mut rays = random_rays(&mut random, &triangles, scale.clamp(1e-20, 1e20));
        for ray in &mut rays {
            if !ray.is_usable() {
                *ray = Ray::new([0.0; 3], [1.0, 0.5, 0.25]);
            }
            let own = &triangles[random.usize(..4)];
            if let Some(hit) = PreparedRay::new(ray).and_then(|ray| ray.intersect(own)) {
                // Ranges that just hold the hit, or just not.
                match random.u32(..6) {
                    0 => ray.t_max = hit.t,
                    1 => ray.t_max = hit.t.next_down(),
                    2 => (ray.t_min, ray.t_max) = (hit.t, f32::INFINITY),
                    3 => (ray.t_min, ray.t_max) = (hit.t.next_up(), f32::INFINITY),
                    _ => {}
                }
            }
        }
        for level in LEVELS {
            for triangle in &triangles {
                let (found, lanes) = group_hits(level(), &rays, triangle);
                for (place, ray) in rays.iter().enumerate().take(GROUP) {
                    let expected = PreparedRay::new(ray).and_then(|ray| ray.intersect(triangle));
                    let own = (found >> place & 1 == 1).then(|| TriangleHit {
                        t: lanes.t[place],
                        u: lanes.u[place],
                        v: lanes.v[place],
                    });
                    let bits = |hit: Option<TriangleHit>| hit.map(|hit| [hit.t, hit.u, hit.v].map(f32::to_bits));
                    assert_eq!(bits(own), bits(expected), "round {round}: {ray:?} {triangle:?}");
                    hits += u32::from(own.is_some());
                    ends += u32::from(own.is_some_and(|hit| hit.t == ray.t_max || hit.t == ray.t_min));
                }
                assert_eq!(found >> rays.len().min(GROUP), 0);
            }
        }
    }
    assert!(hits > 20_000 && ends > 2_000, "{hits} {ends}");
}

fn group_hits(level: SimdLevel, rays: &[Ray], triangle: &Triangle) -> (u32, GroupHits) {
    fn body<S: Lanes>(simd: S, rays: &[Ray], triangle: &Triangle) -> (u32, GroupHits) {
        let (mut group, mut hits) = (RayGroup::NONE, GroupHits::NONE);
        group.load(simd, &rays[..rays.len().min(GROUP)]);
        (group.hits(simd, triangle, &mut hits), hits)
    }
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        return body(simd, rays, triangle);
    }
    body(Portable, rays, triangle)
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
    let mut bundles = 0;
    let enter = |bundled: &mut Bundled| {
        bundles += 1;
        for level in LEVELS {
            assert_eq!(bundled.meeting(level(), 0b11, &world.bounds), 0x7ff);
            assert_eq!(bundled.meeting(level(), 0b10, &world.bounds), 0x700);
        }
        assert_eq!(bundled.places(), 0x7ff);
        bundled.cut(0, f32::NEG_INFINITY);
        for level in LEVELS {
            assert_eq!(bundled.meeting(level(), 0b11, &world.bounds), 0x7fe);
        }
        assert!(!bundled.is_over());
        for place in 0..11 {
            assert!(!bundled.is_over());
            bundled.cut(place, f32::NEG_INFINITY);
            bundled.shorten(LEVELS[place % 2](), 0b11);
        }
        assert!(bundled.is_over());
    };
    packet.part(
        SimdLevel::detect(),
        &rays,
        &world.nodes[0],
        &world.bounds,
        enter,
        |_| panic!("they are coherent"),
    );
    assert_eq!(bundles, 1);
    packet.part(
        SimdLevel::detect(),
        &[],
        &world.nodes[0],
        &world.bounds,
        |_| panic!(),
        |_| panic!(),
    );
}
