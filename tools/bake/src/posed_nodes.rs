//! Nodes of wide trees whose boxes follow the pose.
//!
//! A fuzzy box is as large as what it holds moves against the cluster, however small the triangle. Near the leaves of a
//! fine mesh that is all there is to a box. There a node keeps the rest positions and the weights of what is below it
//! instead, and the runtime moves its boxes like a vertex, for a few instructions per bone and eight boxes.

use crate::poses::SampledPose;
use restpose_builders::bvh::WideBvh;
use restpose_formats::{
    Model,
    geom::Aabb,
    rows::{ClusterBoneRow, MAX_MOVERS, MOVER_WEIGHTS, NodeMoverRow, RestLattice, WideChild, WideNodeRow, box_steps},
};

/// Poses in which boxes are compared, spread evenly over all.
const POSES: usize = 8;

/// What a ray takes to go through a node, in units of one with fuzzy boxes (15 to 20 ns): with boxes that follow, and per
/// bone that they follow. What is gained hardly depends on them: of fox and cesium_man with 0.6k to 147k triangles, rays took
/// as long with 1.3 and 0.4 as with 3 and 1.5; with 6 and 3, 5 % longer; without nodes that follow, 0.9 to 6 times as long.
const FOLLOWING: f64 = 2.0;
const PER_MOVER: f64 = 0.8;

/// Posing and testing a triangle.
const TEST: f64 = 4.0;

/// The weights of one mover over some vertices.
type Weights = [f32; 2];

/// What is below a place.
#[derive(Clone, Copy)]
struct Below {
    rest: Aabb,
    /// Per mover of the cluster, least and greatest.
    weights: [Weights; MAX_MOVERS],
    /// Whether no other bone moves it.
    is_followed: bool,
    /// Of a ray that meets its box.
    cost: f64,
}

impl Below {
    const NOTHING: Self = Self {
        rest: Aabb::EMPTY,
        weights: [[f32::INFINITY, f32::NEG_INFINITY]; MAX_MOVERS],
        is_followed: true,
        cost: 0.0,
    };

    fn add(&mut self, other: &Self) {
        self.rest = self.rest.union(other.rest);
        self.is_followed &= other.is_followed;
        for (own, [least, greatest]) in self.weights.iter_mut().zip(other.weights) {
            *own = [own[0].min(least), own[1].max(greatest)];
        }
    }

    fn moves(&self, mover: usize) -> bool {
        self.weights[mover][1] > 0.0
    }
}

/// The relative motions of a cluster's movers in a pose: rows of E, then d, in steps of the lattice.
type Motions = Vec<[[f64; 4]; 3]>;

/// A cluster for which nodes are chosen.
pub(crate) struct FollowedCluster<'a> {
    pub model: &'a Model,
    /// Bone row.
    pub bone: u32,
    pub cluster_bones: &'a [ClusterBoneRow],
    pub poses: &'a [SampledPose],
}

impl FollowedCluster<'_> {
    /// Gives `tree`, over the fuzzy boxes of these triangle rows, boxes that follow the pose where rays are expected to be
    /// the cheaper for it. Returns the movers of its nodes, which count in them.
    ///
    /// Guarantee: the same on any number of threads.
    ///
    /// Complexity: linear in the nodes, for each of the poses.
    pub(crate) fn follow(&self, tree: &mut WideBvh, triangle: impl Fn(u32) -> u32) -> Vec<NodeMoverRow> {
        let lattice = RestLattice::new(self.cluster_bones);
        let movers: Vec<u32> = self
            .cluster_bones
            .iter()
            .map(|row| row.bone)
            .filter(|bone| *bone != self.bone)
            .take(MAX_MOVERS)
            .collect();
        if movers.is_empty() || !lattice.is_usable() {
            return Vec::new();
        }
        let motions = self.motions(&movers, &lattice);
        if motions.is_empty() {
            return Vec::new();
        }
        let choice = Choice {
            lattice,
            steps: box_steps(&tree.bounds).map(f64::from),
            motions,
        };
        let places = |node: &WideNodeRow, below: &[Below]| -> Vec<Below> {
            let held = |child| match child {
                WideChild::Node(index) => below[index as usize],
                WideChild::Leaf(place) => self.triangle(triangle(place), &movers),
                WideChild::Empty => Below::NOTHING,
            };
            node.children().map(held).collect()
        };
        let mut below = vec![Below::NOTHING; tree.nodes.len()];
        let mut follows = vec![false; tree.nodes.len()];
        // Children stand behind their parents.
        for at in (0..tree.nodes.len()).rev() {
            let node = &tree.nodes[at];
            let places = places(node, &below);
            let mut all = Below::NOTHING;
            places.iter().for_each(|place| all.add(place));
            (follows[at], all.cost) = choice.of_node(node, &places, &all);
            below[at] = all;
        }
        let mut rows = Vec::new();
        for at in 0..tree.nodes.len() {
            tree.nodes[at].mover_first = rows.len() as u32;
            if !follows[at] {
                continue;
            }
            let node = &mut tree.nodes[at];
            let places = places(node, &below);
            for (place, held) in places.iter().enumerate() {
                let [min, max] = lattice.around(&held.rest);
                for k in 0..3 {
                    (node.min[k][place], node.max[k][place]) = (min[k], max[k]);
                }
            }
            for mover in (0..movers.len()).filter(|mover| places.iter().any(|place| place.moves(*mover))) {
                let mut row = NodeMoverRow {
                    mover: mover as u32,
                    ..NodeMoverRow::default()
                };
                for (place, held) in places.iter().enumerate() {
                    (row.weight[place], row.spread[place]) = middle_and_spread(held.weights[mover]);
                }
                rows.push(row);
            }
            node.mover_count = rows.len() as u32 - node.mover_first;
        }
        rows
    }

    fn triangle(&self, row: u32, movers: &[u32]) -> Below {
        let mut out = Below::NOTHING;
        for corner in self.model.triangles[row as usize].corners {
            let mut vertex = Below {
                rest: Aabb::EMPTY.with_point(self.model.vertices[corner as usize].position_rest),
                weights: [[0.0; 2]; MAX_MOVERS],
                ..Below::NOTHING
            };
            for influence in self.model.influences_of(corner as usize) {
                if influence.bone == self.bone {
                    continue;
                }
                match movers.iter().position(|mover| *mover == influence.bone) {
                    Some(mover) => vertex.weights[mover] = [influence.weight; 2],
                    None => vertex.is_followed = false,
                }
            }
            out.add(&vertex);
        }
        out.cost = TEST;
        out
    }

    /// Of poses in which the own bone has an inverse.
    fn motions(&self, movers: &[u32], lattice: &RestLattice) -> Vec<Motions> {
        let count = self.poses.len().min(POSES);
        let (step, origin) = (f64::from(lattice.step), lattice.origin.map(f64::from));
        let of_pose = |pose: &SampledPose| {
            let inverse = pose.inverses[self.bone as usize]?;
            let columns = |bone: u32| pose.palette[bone as usize].columns.map(|column| column.map(f64::from));
            let own = columns(self.bone);
            let motion = |bone: &u32| {
                let x = columns(*bone);
                std::array::from_fn(|k| {
                    let turned = |v: [f64; 3]| inverse[k][0] * v[0] + inverse[k][1] * v[1] + inverse[k][2] * v[2];
                    let e: [f64; 3] = std::array::from_fn(|j| turned(x[j]) - if j == k { 1.0 } else { 0.0 });
                    let away = turned(std::array::from_fn(|i| x[3][i] - own[3][i]));
                    let at_origin = away + e[0] * origin[0] + e[1] * origin[1] + e[2] * origin[2];
                    [e[0], e[1], e[2], at_origin / step]
                })
            };
            Some(movers.iter().map(motion).collect())
        };
        (0..count)
            .filter_map(|place| of_pose(&self.poses[place * self.poses.len() / count]))
            .collect()
    }
}

/// The weights around a middle, in parts of [`MOVER_WEIGHTS`].
fn middle_and_spread([least, greatest]: Weights) -> (u16, u16) {
    let parts = |weight: f32| f64::from(weight) * f64::from(MOVER_WEIGHTS);
    let (least, greatest) = (parts(least), parts(greatest));
    // The cast saturates.
    let middle = (0.5 * (least + greatest)).round() as u16;
    let off = (greatest - f64::from(middle)).max(f64::from(middle) - least);
    (middle, off.ceil() as u16)
}

/// How nodes are chosen.
struct Choice {
    lattice: RestLattice,
    /// Of the fuzzy boxes.
    steps: [f64; 3],
    /// Per pose.
    motions: Vec<Motions>,
}

impl Choice {
    /// Whether a node's boxes are to follow the pose, and what a ray that meets its box is expected to cost then.
    fn of_node(&self, node: &WideNodeRow, places: &[Below], all: &Below) -> (bool, f64) {
        let fuzzy: Vec<f64> = (0..places.len())
            .map(|place| area([0, 1, 2].map(|k| f64::from(node.max[k][place] - node.min[k][place]) * self.steps[k])))
            .collect();
        let union = |k: usize| {
            let sides = (0..places.len()).map(|place| (node.min[k][place], node.max[k][place]));
            let (min, max) = sides.fold((u16::MAX, 0), |(a, b), (min, max)| (a.min(min), b.max(max)));
            f64::from(max - min.min(max)) * self.steps[k]
        };
        let fuzzy_whole = area([union(0), union(1), union(2)]);
        let posed_whole = self.posed_area(all);
        let whole = fuzzy_whole.min(posed_whole);
        let cost = |areas: &dyn Fn(usize) -> f64| {
            let shares = places.iter().enumerate().map(|(place, below)| {
                let share = areas(place) / whole;
                below.cost * if share <= 1.0 { share } else { 1.0 }
            });
            shares.sum::<f64>()
        };
        let alone = 1.0 + cost(&|place| fuzzy[place]);
        if !all.is_followed {
            return (false, alone);
        }
        let movers = (0..MAX_MOVERS).filter(|mover| all.moves(*mover)).count();
        if movers == 0 {
            return (false, alone);
        }
        let posed: Vec<f64> = places.iter().map(|place| self.posed_area(place)).collect();
        let following = FOLLOWING + PER_MOVER * movers as f64 + cost(&|place| posed[place]);
        if following < alone {
            (true, following)
        } else {
            (false, alone)
        }
    }

    /// Mean area of the box that follows.
    fn posed_area(&self, below: &Below) -> f64 {
        let step = f64::from(self.lattice.step);
        let (mut center, mut half) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let origin = f64::from(self.lattice.origin[k]);
            let (min, max) = (f64::from(below.rest.min[k]), f64::from(below.rest.max[k]));
            center[k] = (0.5 * (min + max) - origin) / step;
            half[k] = 0.5 * (max - min) / step;
        }
        let of_pose = |motions: &Motions| {
            let sides = std::array::from_fn(|k| {
                let mut side = half[k];
                for (motion, [least, greatest]) in motions.iter().zip(below.weights).filter(|(_, w)| w[1] > 0.0) {
                    let [e0, e1, e2, offset] = motion[k];
                    let moved = e0 * center[0] + e1 * center[1] + e2 * center[2] + offset;
                    let spun = e0.abs() * half[0] + e1.abs() * half[1] + e2.abs() * half[2];
                    let spread = 0.5 * f64::from(greatest - least);
                    side += spread * moved.abs() + f64::from(greatest) * spun;
                }
                2.0 * side * step
            });
            area(sides)
        };
        self.motions.iter().map(of_pose).sum::<f64>() / self.motions.len() as f64
    }
}

fn area([x, y, z]: [f64; 3]) -> f64 {
    2.0 * (x * y + y * z + z * x)
}
