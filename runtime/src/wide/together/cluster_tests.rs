//! Bundles in clusters' local spaces, against points that lie on the planes of boxes, or by the whole excess beside them: each is
//! hit as far off as rays may be, and its leaf has to be visited.

use super::{bundled::Together, *};
use crate::{
    Aabb, Affine, Ray,
    cluster_frame::{ClusterFrame, FrameInputs, LocalFrame, Map64, PosedMap, Way},
    mover_maps::MoverMaps,
    set_bits::set_bits,
    simd::{Doubles, Portable, SimdLevel},
    wide::{FuzzyBoxes, WideNode, WideStack},
};
use fastrand::Rng;
use restpose_formats::{
    geom::round::{f32_above, f32_below},
    rows::{MAX_WIDE_DEPTH, NodeMoverRow, RestLattice, WideChild, WideNodeRow},
};

type Point = [f64; 3];

/// A box of one point on one of the two lattices.
struct Leaf {
    follows: bool,
    steps: [u16; 3],
    /// Where its triangle is: beside the box, but not farther than the lattice's boxes may be off.
    local: Point,
    world: Point,
}

/// A cluster in a pose, whose nodes that follow it have movers that do not move.
struct Cluster {
    map: Affine,
    frame: ClusterFrame,
    zero: [f32; 3],
    step: [f32; 3],
    rest: RestLattice,
    leaves: Vec<Leaf>,
    rows: Vec<WideNodeRow>,
    movers: Vec<NodeMoverRow>,
    motions: MoverMaps,
}

fn signed(random: &mut Rng) -> f64 {
    random.f64() * 2.0 - 1.0
}

fn choose<T: Copy>(random: &mut Rng, of: &[T]) -> T {
    of[random.usize(..of.len())]
}

fn random_map(random: &mut Rng) -> Affine {
    let scale = choose(random, &[1.0, 1.0, 1e-6, 1e6, 1e-12, 1e9]);
    let axes: [f64; 3] = choose(
        random,
        &[[1.0; 3], [1.0; 3], [1.0, 0.1, 3.0], [1e-3, 1.0, 1.0], [1.0, 1e-2, 30.0]],
    );
    let mut columns = [[0.0; 3]; 4];
    // Turned by a random unit quaternion, or not at all.
    let mut q: [f64; 4] = match random.u32(..5) {
        0 => [0.0, 0.0, 0.0, 1.0],
        _ => std::array::from_fn(|_| signed(random)),
    };
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q = q.map(|x| x / length);
    let [x, y, z, w] = q;
    let turn = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + z * w),
            2.0 * (x * z - y * w),
        ],
        [
            2.0 * (x * y - z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + x * w),
        ],
        [
            2.0 * (x * z + y * w),
            2.0 * (y * z - x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    for j in 0..3 {
        columns[j] = std::array::from_fn(|k| (turn[j][k] * axes[j] * scale) as f32);
    }
    let away = choose(random, &[0.0, 1.0, 300.0]);
    columns[3] = std::array::from_fn(|_| (signed(random) * away * scale) as f32);
    Affine { columns }
}

fn image(map: &Affine, p: Point) -> Point {
    let c = map.columns.map(|column| column.map(f64::from));
    std::array::from_fn(|k| c[0][k] * p[0] + c[1][k] * p[1] + c[2][k] * p[2] + c[3][k])
}

/// `None` where the map is of no use as a frame. With `overflown`, movers are so far away along an axis that where boxes that
/// follow are is no number there.
fn random_cluster(random: &mut Rng, overflown: bool) -> Option<Cluster> {
    let size = choose(random, &[1.0, 1e-3, 1e4]);
    let offset = choose(random, &[0.0, 0.0, 3.0, -200.0]) * size;
    let zero: [f32; 3] = std::array::from_fn(|_| (offset + signed(random) * size) as f32);
    let side: [f64; 3] = std::array::from_fn(|_| size * choose(random, &[1.0, 0.6, 0.03]));
    let step = side.map(|side| (side / 65_600.0) as f32);
    let rest = RestLattice {
        origin: std::array::from_fn(|k| (f64::from(zero[k]) - 1e-4 * size) as f32),
        step: (size * 1.01 / 65_533.0) as f32,
    };
    let bounds_local = Aabb {
        min: zero,
        max: std::array::from_fn(|k| f32_above(f64::from(zero[k]) + side[k])),
    };
    // Of the two kinds now one is off by more, now the other.
    let mut off = || choose(random, &[0.0, 0.0, 1e-5, 1e-3]) * size;
    let [excess, mut posed_error] = [off(), off()].map(|off| [off, off, 0.5 * off]);
    let mut motions = MoverMaps::NONE;
    if overflown {
        let axis = random.usize(..3);
        posed_error[axis] = f64::INFINITY;
        motions.maps[0].columns[3][axis] = choose(random, &[f32::INFINITY, f32::NEG_INFINITY]);
    }

    let count = choose(random, &[2, 12, 12, 60, 300]);
    let kinds = choose(random, &[0.0, 0.5, 1.0]);
    let map = random_map(random);
    let leaves: Vec<Leaf> = (0..count)
        .map(|_| {
            let follows = random.f64() < kinds;
            let inside: Point = std::array::from_fn(|k| {
                // Inside of both lattices, with room for what they are off by.
                side[k] * (0.1 + 0.8 * random.f64())
            });
            let local: Point = std::array::from_fn(|k| f64::from(zero[k]) + inside[k]);
            let (origin, steps, off) = if follows {
                (rest.origin, [rest.step; 3], posed_error)
            } else {
                (zero, step, excess)
            };
            let at = |k: usize| ((local[k] - f64::from(origin[k])) / f64::from(steps[k])).round() as u16;
            let place = [at(0), at(1), at(2)];
            let local: Point = std::array::from_fn(|k| {
                let plane = f64::from(origin[k]) + f64::from(place[k]) * f64::from(steps[k]);
                if off[k] == f64::INFINITY {
                    return local[k];
                }
                plane + off[k] * choose(random, &[0.999, -0.999, 0.0])
            });
            Leaf {
                follows,
                steps: place,
                local,
                world: image(&map, local),
            }
        })
        .collect();
    let mut bounds_world = Aabb::EMPTY;
    for leaf in &leaves {
        let corner = Aabb {
            min: leaf.world.map(f32_below),
            max: leaf.world.map(f32_above),
        };
        bounds_world = bounds_world.union(corner);
    }
    let inputs = FrameInputs {
        frame: &PosedMap::product(Portable, &[&Map64::new(&map)]),
        bounds_local: &bounds_local,
        reach: Doubles::splat(Portable, 0.0),
        vertex_error: 0.0,
        bounds_world: &bounds_world,
        excess,
        posed_error,
    };
    let frame = ClusterFrame::new(Portable, &inputs)?;
    let mut out = Cluster {
        map,
        frame,
        zero,
        step,
        rest,
        leaves,
        rows: Vec::new(),
        movers: Vec::new(),
        motions,
    };
    let all: Vec<u32> = (0..count as u32).collect();
    out.add_node(random, all);
    Some(out)
}

impl Cluster {
    /// Appends a node over some leaves; its index.
    fn add_node(&mut self, random: &mut Rng, mut of: Vec<u32>) -> u32 {
        let axis = random.usize(..3);
        let along = |leaf: &u32| self.leaves[*leaf as usize].local[axis];
        of.sort_by(|a, b| along(a).total_cmp(&along(b)));
        // Leaves are of their node's kind.
        let leaves_of = |follows: bool| {
            of.iter()
                .filter(|leaf| self.leaves[**leaf as usize].follows == follows)
                .count()
        };
        let follows = match (leaves_of(true), leaves_of(false)) {
            (0, _) => false,
            (_, 0) => true,
            _ => random.bool(),
        };
        let index = self.rows.len() as u32;
        self.rows.push(WideNodeRow::EMPTY);
        let mut places: Vec<Vec<u32>> = vec![Vec::new(); random.usize(2..=8)];
        let parts = places.len();
        for (at, leaf) in of.iter().enumerate() {
            places[at * parts / of.len()].push(*leaf);
        }
        places.retain(|place| !place.is_empty());
        let mut row = WideNodeRow::EMPTY;
        for (at, place) in places.iter().enumerate() {
            for k in 0..3 {
                row.min[k][at] = place.iter().map(|leaf| self.side(follows, *leaf, k)[0]).min().unwrap();
                row.max[k][at] = place.iter().map(|leaf| self.side(follows, *leaf, k)[1]).max().unwrap();
            }
            let is_leaf = place.len() == 1 && self.leaves[place[0] as usize].follows == follows;
            let child = if is_leaf {
                WideChild::Leaf(place[0])
            } else {
                WideChild::Node(self.add_node(random, place.clone()))
            };
            row.children[at] = child.pack();
        }
        if follows {
            (row.mover_first, row.mover_count) = (self.movers.len() as u32, 1);
            // They move nothing, or it is not known where to.
            self.movers.push(NodeMoverRow {
                weight: [1 << 8; 8],
                spread: [1 << 8; 8],
                ..NodeMoverRow::default()
            });
        }
        self.rows[index as usize] = row;
        index
    }

    /// Of the box of a leaf on one of the lattices, along an axis.
    fn side(&self, follows: bool, leaf: u32, k: usize) -> [u16; 2] {
        let leaf = &self.leaves[leaf as usize];
        if leaf.follows == follows {
            return [leaf.steps[k]; 2];
        }
        let (origin, step) = if follows {
            (self.rest.origin[k], self.rest.step)
        } else {
            (self.zero[k], self.step[k])
        };
        let at = (leaf.local[k] - f64::from(origin)) / f64::from(step);
        [(at - 1e-6).floor() as u16, (at + 1e-6).ceil() as u16]
    }

    fn boxes(&self) -> FuzzyBoxes<'_> {
        FuzzyBoxes {
            keys: None,
            motions: &self.motions,
            movers: &self.movers,
        }
    }

    fn local(&self) -> &LocalFrame {
        match &self.frame.way {
            Way::Local(local) => local,
            _ => unreachable!("others are not made here"),
        }
    }

    /// Leaves below a node, as a set.
    fn below(&self, node: u32, out: &mut Vec<u32>) {
        for child in self.rows[node as usize].children {
            match WideChild::unpack(child) {
                WideChild::Node(node) => self.below(node, out),
                WideChild::Leaf(leaf) => out.push(leaf),
                WideChild::Empty => {}
            }
        }
    }

    /// Rays to some leaves, one each, and the leaf of each: of one eye, or parallel.
    fn rays(&self, random: &mut Rng) -> Vec<(Ray, u32)> {
        let count = choose(random, &[8, 13, 32, 64, 64]);
        let of = choose(random, &[1, 1, 2, 64]);
        let targets: Vec<u32> = (0..of).map(|_| random.u32(..self.leaves.len() as u32)).collect();
        let size = (0..3).fold(0.0, |most: f64, k| most.max(f64::from(self.step[k]) * 65_535.0));
        // In local space, most often along an axis, or a plane, so that rays there run both ways.
        let mut along: Point = std::array::from_fn(|_| signed(random));
        match random.u32(..3) {
            0 => along[random.usize(..3)] = 0.0,
            1 => {
                along = [0.0; 3];
                along[random.usize(..3)] = choose(random, &[1.0, -1.0]);
            }
            _ => {}
        }
        let far = size * choose(random, &[0.01, 2.0, 50.0, 50.0, 1e4]);
        let parallel = random.u32(..4) == 0;
        let parted = random.u32(..3) == 0;
        let jitter = choose(random, &[0.0, 0.0, 1e-6, 1e-2]) * size;
        let from = self.leaves[targets[0] as usize].local;
        let length = 2f64.powf(signed(random) * choose(random, &[0.0, 20.0]));
        (0..count)
            .map(|place| {
                // A group of one ray again and again is as narrow as can be.
                let leaf = targets[if parted { place } else { place / GROUP } % of];
                let Leaf { local, world, .. } = &self.leaves[leaf as usize];
                let around = if parallel { *local } else { from };
                let eye: Point = std::array::from_fn(|k| around[k] - along[k] * far + jitter * signed(random));
                let origin = image(&self.map, eye).map(|x| x as f32);
                let towards: Point = std::array::from_fn(|k| world[k] - f64::from(origin[k]));
                let longest = towards.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                let scale = length / longest;
                let mut ray = Ray::new(origin, towards.map(|x| (x * scale) as f32));
                let t = 1.0 / scale;
                match random.u32(..4) {
                    0 => ray.t_max = (t * 1.001) as f32,
                    1 => (ray.t_min, ray.t_max) = ((t * 0.999) as f32, (t * 1.001) as f32),
                    2 => ray.t_min = f32::NEG_INFINITY,
                    _ => {}
                }
                (ray, leaf)
            })
            .collect()
    }
}

/// What is kept from packet to packet.
struct Room {
    packet: Packet,
    rays: LocalRays,
    path: Box<FuzzyPath>,
    stack: WideStack,
}

#[derive(Clone, Debug, PartialEq)]
struct Visits {
    places: u64,
    groups: u32,
    leaves: Vec<(u32, u32)>,
    alone: Vec<(u32, u64)>,
}

/// `groups` are those of a bundle's that go, if any of them is in it.
fn visits(level: SimdLevel, cluster: &Cluster, rays: &[Ray], groups: u32, room: &mut Room) -> Vec<Visits> {
    let bounds = &cluster.frame.bounds_world;
    let mut root = WideNode::EMPTY;
    root.set_bounds(0, bounds);
    root.children[0] = WideChild::Leaf(0).pack();
    let Room {
        packet,
        rays: local_rays,
        path,
        stack,
    } = room;
    let mut out = Vec::new();
    let enter = |bundled: &mut Bundled| {
        let own = bundled.groups;
        let groups = if own & groups == 0 { own } else { own & groups };
        let mut found = Visits {
            places: bundled.places(),
            groups,
            leaves: Vec::new(),
            alone: Vec::new(),
        };
        let Some((together, frame)) = bundled.in_cluster(level, groups, (cluster.local(), bounds), local_rays) else {
            panic!("{cluster:?}", cluster = cluster.map);
        };
        assert_usable(&together, groups);
        let rest = &cluster.rest;
        let lattices = [
            LocalLattice::new(cluster.zero, cluster.step, frame.margin),
            LocalLattice::new(rest.origin, [rest.step; 3], frame.margin_posed),
        ];
        let mut tree = FuzzyNodes::new(&cluster.rows, cluster.boxes(), lattices, path);
        let mut visit = |part: Part, _: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => found.leaves.push((leaf, groups)),
                Part::Alone { node, places } => found.alone.push((node, places)),
            }
            false
        };
        walk_together(level, &mut tree, &together, bundled, stack, &mut visit);
        out.push(found);
    };
    packet.part(level, rays, &root, bounds, enter, |_| {});
    out
}

/// Directions have inverses.
fn assert_usable(together: &Together, groups: u32) {
    let rays = together.rays.expect("the tree is in its own space");
    for group in set_bits(groups.into()) {
        let inverses = rays[group].inverse_direction.as_flattened();
        assert!(inverses.iter().all(|x| x.is_normal()), "{inverses:?}");
    }
}

/// Rays whose leaves were visited with others, and such that went on alone.
fn visited(rounds: usize, overflown: bool) -> [usize; 2] {
    let mut random = Rng::with_seed(71);
    let mut room = Room {
        packet: Packet::new(),
        rays: LocalRays::NONE,
        path: Box::new([WideNode::EMPTY; MAX_WIDE_DEPTH]),
        stack: WideStack::new(),
    };
    let mut found = [0, 0];
    for round in 0..rounds {
        let Some(cluster) = random_cluster(&mut random, overflown) else {
            continue;
        };
        let mut below: Vec<Vec<u32>> = Vec::new();
        for node in 0..cluster.rows.len() as u32 {
            below.push(Vec::new());
            cluster.below(node, &mut below[node as usize]);
        }
        for _ in 0..4 {
            let (rays, targets): (Vec<Ray>, Vec<u32>) = cluster.rays(&mut random).into_iter().unzip();
            let groups = choose(&mut random, &[0xff, 0xff, 0b0110_1010, 1]);
            let bundles = visits(SimdLevel::detect(), &cluster, &rays, groups, &mut room);
            let portable = visits(SimdLevel::Portable, &cluster, &rays, groups, &mut room);
            assert_eq!(bundles, portable, "round {round}");
            for bundle in bundles {
                for place in set_bits(bundle.places).filter(|place| bundle.groups >> (place / GROUP) & 1 == 1) {
                    let target = targets[place];
                    let mut leaves = bundle.leaves.iter();
                    let with_others =
                        leaves.any(|(leaf, groups)| *leaf == target && groups >> (place / GROUP) & 1 == 1);
                    let mut alone = bundle.alone.iter();
                    let alone =
                        alone.any(|(node, places)| places >> place & 1 == 1 && below[*node as usize].contains(&target));
                    assert!(with_others || alone, "round {round}, place {place}: {:?}", rays[place]);
                    found[usize::from(!with_others)] += 1;
                }
            }
        }
    }
    found
}

#[test]
fn bundles_visit_what_their_rays_may_hit() {
    let found = visited(6_000, false);
    assert!(found[0] > 100_000 && found[1] > 5_000, "{found:?}");
}

#[test]
fn boxes_that_are_nowhere_restrict_nothing() {
    let found = visited(1_000, true);
    assert!(found[0] > 10_000 && found[1] > 500, "{found:?}");
}
