//! Fuzzy trees of either kind, in exact arithmetic: where a point is found in them. Planes and boxes that hold in a pose
//! space are widened; those that follow the pose are not.
//!
//! Written from `FORMAT.md`, sections 6.4 to 6.8.

use crate::{
    Dyadic,
    escapes::{Point, exact},
    followed_nodes::{Followed, PosedBox},
    wide_boxes,
};
use restpose_formats::{
    ModelView, TreeKind,
    rows::{ClusterRow, KdNode, ReferenceBoxRow, WideChild, WideNodeRow, box_steps},
};
use std::collections::BTreeMap;

/// Turns planes in a cluster's local space into what scaled fuzzy positions are compared with.
pub(crate) struct Widened<'a> {
    /// Of the fuzzy positions.
    pub scale: &'a Dyadic,
    pub excess: Point,
}

impl Widened<'_> {
    /// The plane moved by the excess, downwards and upwards.
    fn plane(&self, axis: usize, at: &Dyadic) -> [Dyadic; 2] {
        let (scale, excess) = (self.scale, &self.excess[axis]);
        [scale * &(at - excess), scale * &(at + excess)]
    }
}

/// The box of a triangle or a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Bounds {
    /// On the lattice of the fuzzy boxes, to be widened.
    Fuzzy(ReferenceBoxRow),
    /// That of a node with movers in this pose.
    Posed(Box<PosedBox>),
}

enum Node {
    /// The left child and the right one begin at the first and end at the second.
    Inner {
        axis: usize,
        plane: [Dyadic; 2],
        left: usize,
    },
    Leaf {
        first: usize,
        count: usize,
    },
    /// What stands in the places of a wide node, with its boxes.
    Wide(Vec<(WideChild, Bounds)>),
}

impl Node {
    fn boxes(&self) -> &[(WideChild, Bounds)] {
        match self {
            Self::Wide(places) => places,
            Self::Inner { .. } | Self::Leaf { .. } => &[],
        }
    }
}

fn nodes(model: &ModelView, cluster: &ClusterRow, widened: &Widened, followed: &Followed) -> Vec<Node> {
    let rows = cluster.node_first as usize..(cluster.node_first + cluster.node_count) as usize;
    let kd = |row: KdNode| match row {
        KdNode::Inner { axis, split, left } => Node::Inner {
            axis,
            plane: widened.plane(axis, &Dyadic::from(split)),
            left: left as usize,
        },
        KdNode::Leaf { first, count } => Node::Leaf {
            first: first as usize,
            count: count as usize,
        },
    };
    let wide = |row: &WideNodeRow| {
        let places = wide_boxes(row).enumerate().map(|(place, (child, own))| {
            let bounds = if row.mover_count == 0 {
                Bounds::Fuzzy(own)
            } else {
                Bounds::Posed(Box::new(followed.posed_box(row, place, &own)))
            };
            (child, bounds)
        });
        Node::Wide(places.collect())
    };
    match model.meta.tree {
        TreeKind::Kd => model.kd_nodes[rows].iter().map(|row| kd(row.unpack())).collect(),
        TreeKind::Wide => model.wide_nodes[rows].iter().map(wide).collect(),
    }
}

/// A fuzzy tree, its planes and boxes widened.
pub(crate) struct Tree<'a> {
    /// The triangles of leaves.
    references: &'a [u32],
    /// Their boxes.
    boxes: Vec<Bounds>,
    /// Per axis the planes of the lattice that boxes use, by coordinate: widened downwards and upwards.
    lattice: [BTreeMap<u16, [Dyadic; 2]>; 3],
    /// Per axis.
    bounds: [[Dyadic; 2]; 3],
    nodes: Vec<Node>,
}

impl<'a> Tree<'a> {
    pub(crate) fn new(model: &ModelView<'a>, cluster: &ClusterRow, widened: &Widened, followed: &Followed) -> Self {
        let bounds = &cluster.bounds_local;
        let references = cluster.reference_first as usize..(cluster.reference_first + cluster.reference_count) as usize;
        let references = &model.references[references];
        let nodes = nodes(model, cluster, widened, followed);
        let boxes: Vec<Bounds> = match model.meta.tree {
            TreeKind::Kd => {
                let rows = &model.reference_boxes[cluster.reference_first as usize..][..references.len()];
                rows.iter().copied().map(Bounds::Fuzzy).collect()
            }
            // In the order of the references, which are those of the leaves (6.5).
            TreeKind::Wide => nodes
                .iter()
                .flat_map(Node::boxes)
                .filter(|(child, _)| matches!(child, WideChild::Leaf(_)))
                .map(|(_, bounds)| bounds.clone())
                .collect(),
        };
        assert_eq!(boxes.len(), references.len(), "a box per reference");
        // The step's own arithmetic is part of the format (6.6).
        let (min, step) = (exact(bounds.min), exact(box_steps(bounds)));
        let lattice = std::array::from_fn(|k| {
            let inner = nodes.iter().flat_map(Node::boxes).map(|(_, bounds)| bounds);
            let used = inner.chain(&boxes).flat_map(|bounds| match bounds {
                Bounds::Fuzzy(row) => vec![row.min[k], row.max[k]],
                Bounds::Posed(_) => Vec::new(),
            });
            let plane = |q: u16| widened.plane(k, &(&min[k] + &(&step[k] * &Dyadic::from(f64::from(q)))));
            used.map(|q| (q, plane(q))).collect()
        });
        Self {
            references,
            boxes,
            lattice,
            bounds: std::array::from_fn(|k| {
                let [low, _] = widened.plane(k, &Dyadic::from(bounds.min[k]));
                let [_, high] = widened.plane(k, &Dyadic::from(bounds.max[k]));
                [low, high]
            }),
            nodes,
        }
    }

    /// Triangles, ascending, each with the different boxes that leaves have of it.
    pub(crate) fn boxes_by_triangle(&self) -> BTreeMap<u32, Vec<&Bounds>> {
        let mut out: BTreeMap<u32, Vec<&Bounds>> = BTreeMap::new();
        for (triangle, bounds) in self.references.iter().zip(&self.boxes) {
            let boxes = out.entry(*triangle).or_default();
            if !boxes.contains(&bounds) {
                boxes.push(bounds);
            }
        }
        out
    }

    pub(crate) fn holds(&self, bounds: &Bounds, point: &Point) -> bool {
        match bounds {
            Bounds::Fuzzy(row) => (0..3).all(|k| {
                let plane = |q: u16| &self.lattice[k][&q];
                plane(row.min[k])[0] <= point[k] && point[k] <= plane(row.max[k])[1]
            }),
            Bounds::Posed(posed) => posed.holds(point),
        }
    }

    pub(crate) fn bounds_hold(&self, point: &Point) -> bool {
        (0..3).all(|k| self.bounds[k][0] <= point[k] && point[k] <= self.bounds[k][1])
    }

    pub(crate) fn finds(&self, triangle: u32, point: &Point) -> bool {
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            match &self.nodes[node] {
                Node::Leaf { first, count } => {
                    if self.references[*first..][..*count].contains(&triangle) {
                        return true;
                    }
                }
                Node::Wide(places) => {
                    for (child, _) in places.iter().filter(|(_, bounds)| self.holds(bounds, point)) {
                        match child {
                            WideChild::Leaf(leaf) if *leaf == triangle => return true,
                            WideChild::Node(node) => stack.push(*node as usize),
                            WideChild::Leaf(_) | WideChild::Empty => {}
                        }
                    }
                }
                Node::Inner { axis, plane, left } => {
                    if point[*axis] <= plane[1] {
                        stack.push(*left);
                    }
                    if point[*axis] >= plane[0] {
                        stack.push(left + 1);
                    }
                }
            }
        }
        false
    }
}
