//! Nodes of wide trees whose boxes follow the pose, in exact arithmetic: whether what is below them is as they say, and
//! where their boxes are.
//!
//! Written from what [`NodeMoverRow`] and [`RestLattice`] promise; no arithmetic is shared with the baker or the runtime.

use crate::{
    Dyadic,
    escapes::{Frame, Motion, Point, exact},
    wide_boxes,
};
use restpose_formats::{
    ModelView,
    rows::{
        ClusterBoneRow, ClusterRow, MOVER_WEIGHTS, NONE, NodeMoverRow, ReferenceBoxRow, RestLattice, WideChild,
        WideNodeRow,
    },
};
use std::collections::{BTreeMap, BTreeSet};

/// What a node with movers says wrongly of a vertex below one of its places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Untruth {
    /// Its rest position is outside of the place's box.
    RestBox,
    /// A bone moves it that is not among the node's movers.
    Mover,
    /// The weight of a mover is not within the spread.
    Weight,
}

/// A vertex that is not as a node with movers says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contradiction {
    /// Cluster row.
    pub cluster: u32,
    /// Node, from the first of its tree.
    pub node: u32,
    /// Place in the node.
    pub place: u32,
    /// Vertex row.
    pub vertex: u32,
    /// What is wrong.
    pub untruth: Untruth,
}

/// All contradictions between the nodes with movers of a file and the vertices below them, whatever the pose.
#[must_use]
pub fn contradictions(model: &ModelView) -> Vec<Contradiction> {
    let mut out = Vec::new();
    for (row, cluster) in (0u32..).zip(model.clusters).filter(|(_, row)| row.track == NONE) {
        let nodes = nodes(model, cluster);
        let below = triangles_below(nodes);
        let lattice = RestLattice::new(cluster_bones(model, cluster));
        for (node, own) in (0u32..).zip(nodes).filter(|(_, node)| node.mover_count != 0) {
            let places = wide_boxes(own).zip(triangles_by_place(own, &below));
            for (place, ((_, rest), triangles)) in (0u32..).zip(places) {
                let corners = triangles
                    .iter()
                    .flat_map(|triangle| model.triangles[*triangle as usize].corners);
                let movers = Movers::new(model, cluster, own, place as usize);
                for vertex in corners.collect::<BTreeSet<u32>>() {
                    let mut add = |untruth| {
                        out.push(Contradiction {
                            cluster: row,
                            node,
                            place,
                            vertex,
                            untruth,
                        });
                    };
                    let position = exact(model.vertices[vertex as usize].position_rest);
                    let [min, max] = corners_of(&lattice, &rest);
                    if !(0..3).all(|k| min[k] <= position[k] && position[k] <= max[k]) {
                        add(Untruth::RestBox);
                    }
                    movers.judge(model, vertex, &mut add);
                }
            }
        }
    }
    out
}

pub(crate) fn nodes<'a>(model: &ModelView<'a>, cluster: &ClusterRow) -> &'a [WideNodeRow] {
    model
        .wide_nodes
        .get(cluster.node_first as usize..(cluster.node_first + cluster.node_count) as usize)
        .unwrap_or_default()
}

pub(crate) fn cluster_bones<'a>(model: &ModelView<'a>, cluster: &ClusterRow) -> &'a [ClusterBoneRow] {
    &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize]
}

/// Per node.
pub(crate) fn triangles_below(nodes: &[WideNodeRow]) -> Vec<BTreeSet<u32>> {
    let mut out = vec![BTreeSet::new(); nodes.len()];
    // Children stand behind their parents.
    for at in (0..nodes.len()).rev() {
        let all = triangles_by_place(&nodes[at], &out).flatten().collect();
        out[at] = all;
    }
    out
}

/// The triangles below each place of a node, where `below` are those of the nodes behind it.
pub(crate) fn triangles_by_place<'a>(
    node: &'a WideNodeRow,
    below: &'a [BTreeSet<u32>],
) -> impl Iterator<Item = BTreeSet<u32>> + use<'a> {
    node.children().map(|child| match child {
        WideChild::Leaf(triangle) => BTreeSet::from([triangle]),
        WideChild::Node(index) => below[index as usize].clone(),
        WideChild::Empty => BTreeSet::new(),
    })
}

fn corners_of(lattice: &RestLattice, rest: &ReferenceBoxRow) -> [Point; 2] {
    [rest.min, rest.max].map(|corner| {
        std::array::from_fn(|k| {
            let steps = &Dyadic::from(f32::from(corner[k])) * &Dyadic::from(lattice.step);
            &Dyadic::from(lattice.origin[k]) + &steps
        })
    })
}

/// The bones that a node's rows may name, in the order in which they do.
fn other_bones(model: &ModelView, cluster: &ClusterRow) -> Vec<u32> {
    let bones = cluster_bones(model, cluster).iter().map(|row| row.bone);
    bones.filter(|bone| *bone != cluster.bone).collect()
}

/// What a node says of the weights below one of its places.
struct Movers {
    own: u32,
    /// By bone row: weight and spread.
    weights: BTreeMap<u32, [Dyadic; 2]>,
}

impl Movers {
    fn new(model: &ModelView, cluster: &ClusterRow, node: &WideNodeRow, place: usize) -> Self {
        let others = other_bones(model, cluster);
        let weights = node.movers(model.node_movers).iter().map(|row| {
            let parts = [row.weight[place], row.spread[place]].map(part);
            (others[row.mover as usize], parts)
        });
        Self {
            own: cluster.bone,
            weights: weights.collect(),
        }
    }

    fn judge(&self, model: &ModelView, vertex: u32, add: &mut impl FnMut(Untruth)) {
        let mut found: BTreeMap<u32, Dyadic> = BTreeMap::new();
        for influence in model.influences_of(vertex as usize) {
            let sum = found.entry(influence.bone).or_insert_with(Dyadic::zero);
            *sum = &*sum + &Dyadic::from(influence.weight);
        }
        let moving = |bone: &u32| found.get(bone).is_some_and(|weight| !weight.is_zero());
        if found
            .keys()
            .any(|bone| *bone != self.own && moving(bone) && !self.weights.contains_key(bone))
        {
            add(Untruth::Mover);
        }
        for (bone, [weight, spread]) in &self.weights {
            let exact = found.get(bone).cloned().unwrap_or_else(Dyadic::zero);
            if (&exact - weight).abs() > *spread {
                add(Untruth::Weight);
            }
        }
    }
}

/// A part of [`MOVER_WEIGHTS`].
fn part(parts: u16) -> Dyadic {
    // A power of two.
    &Dyadic::from(f32::from(parts)) * &Dyadic::from(1.0 / MOVER_WEIGHTS)
}

/// The boxes of a cluster's nodes with movers in a pose, to be compared with scaled fuzzy positions.
pub(crate) struct Followed<'a> {
    movers: &'a [NodeMoverRow],
    lattice: RestLattice,
    /// By mover.
    motions: Vec<Motion>,
    /// By how much morphs displace a vertex, at most.
    morphed: Point,
    scale: &'a Dyadic,
}

/// Least and greatest corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PosedBox([Point; 2]);

impl PosedBox {
    pub(crate) fn holds(&self, point: &Point) -> bool {
        let [min, max] = &self.0;
        (0..3).all(|k| min[k] <= point[k] && point[k] <= max[k])
    }
}

impl<'a> Followed<'a> {
    /// `maps` are those of the palette, `frame` that of the cluster.
    pub(crate) fn new(
        model: &ModelView<'a>,
        cluster: &ClusterRow,
        frame: &'a Frame,
        maps: &[[Point; 4]],
        morph_weights: &[Dyadic],
    ) -> Self {
        let others = other_bones(model, cluster);
        let mut morphed: Point = std::array::from_fn(|_| Dyadic::zero());
        for (target, weight) in model.morph_targets.iter().zip(morph_weights) {
            let extent = exact(target.extent);
            morphed = std::array::from_fn(|k| &morphed[k] + &(&weight.abs() * &extent[k]));
        }
        Self {
            movers: model.node_movers,
            lattice: RestLattice::new(cluster_bones(model, cluster)),
            motions: others
                .iter()
                .map(|bone| frame.scaled_motion(&maps[*bone as usize]))
                .collect(),
            morphed,
            scale: &frame.scale,
        }
    }

    /// The box of a place that has this one in rest space, times the scale: for a point p = c + e in it, |e| ≤ h, and the
    /// weights w = w̄ ± s, the sum of what `p`, `w·(E·c + d)` and `w·E·e` add is a box about c + Σ w̄·(E·c + d).
    pub(crate) fn posed_box(&self, node: &WideNodeRow, place: usize, rest: &ReferenceBoxRow) -> PosedBox {
        let [min, max] = corners_of(&self.lattice, rest);
        let half = Dyadic::from(0.5);
        let center: Point = std::array::from_fn(|k| &half * &(&min[k] + &max[k]));
        let side: Point = std::array::from_fn(|k| &(&half * &(&max[k] - &min[k])) + &self.morphed[k]);
        let mut middle: Point = std::array::from_fn(|k| self.scale * &center[k]);
        let mut off: Point = std::array::from_fn(|k| self.scale * &side[k]);
        for row in node.movers(self.movers) {
            let motion = &self.motions[row.mover as usize];
            let [weight, spread] = [row.weight[place], row.spread[place]].map(part);
            let moved = motion.of_point(&center);
            let spun = motion.of_half_sides(&side);
            for k in 0..3 {
                middle[k] = &middle[k] + &(&weight * &moved[k]);
                off[k] = &off[k] + &(&spread * &moved[k].abs());
                off[k] = &off[k] + &(&(&weight + &spread) * &spun[k]);
            }
        }
        PosedBox([
            std::array::from_fn(|k| &middle[k] - &off[k]),
            std::array::from_fn(|k| &middle[k] + &off[k]),
        ])
    }
}
