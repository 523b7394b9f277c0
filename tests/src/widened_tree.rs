//! Fuzzy trees of either kind, widened, in exact arithmetic: where a point is found in them.
//!
//! Written from `FORMAT.md`, sections 6.4 to 6.8.

use crate::{
    Dyadic,
    escapes::{Point, exact},
    wide_boxes,
};
use restpose_formats::{
    ModelView, TreeKind,
    rows::{ClusterRow, KdNode, ReferenceBoxRow, WideChild, box_steps},
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
    Wide(Vec<(WideChild, ReferenceBoxRow)>),
}

impl Node {
    fn boxes(&self) -> impl Iterator<Item = (WideChild, ReferenceBoxRow)> {
        let places = match self {
            Self::Wide(places) => places.as_slice(),
            Self::Inner { .. } | Self::Leaf { .. } => &[],
        };
        places.iter().copied()
    }
}

fn nodes(model: &ModelView, cluster: &ClusterRow, widened: &Widened) -> Vec<Node> {
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
    match model.meta.tree {
        TreeKind::Kd => model.kd_nodes[rows].iter().map(|row| kd(row.unpack())).collect(),
        TreeKind::Wide => {
            let rows = model.wide_nodes[rows].iter();
            rows.map(|row| Node::Wide(wide_boxes(row).collect())).collect()
        }
    }
}

/// A fuzzy tree, its planes and boxes widened.
pub(crate) struct Tree<'a> {
    /// The triangles of leaves.
    references: &'a [u32],
    /// Their boxes.
    boxes: Vec<ReferenceBoxRow>,
    /// Per axis the planes of the lattice that boxes use, by coordinate: widened downwards and upwards.
    lattice: [BTreeMap<u16, [Dyadic; 2]>; 3],
    /// Per axis.
    bounds: [[Dyadic; 2]; 3],
    nodes: Vec<Node>,
}

impl<'a> Tree<'a> {
    pub(crate) fn new(model: &ModelView<'a>, cluster: &ClusterRow, widened: &Widened) -> Self {
        let bounds = &cluster.bounds_local;
        let references = cluster.reference_first as usize..(cluster.reference_first + cluster.reference_count) as usize;
        let references = &model.references[references];
        let nodes = nodes(model, cluster, widened);
        let boxes = match model.meta.tree {
            TreeKind::Kd => model.reference_boxes[cluster.reference_first as usize..][..references.len()].to_vec(),
            // In the order of the references, which are those of the leaves (6.5).
            TreeKind::Wide => nodes
                .iter()
                .flat_map(Node::boxes)
                .filter_map(|(child, bounds)| matches!(child, WideChild::Leaf(_)).then_some(bounds))
                .collect(),
        };
        assert_eq!(boxes.len(), references.len(), "a box per reference");
        // The step's own arithmetic is part of the format (6.6).
        let (min, step) = (exact(bounds.min), exact(box_steps(bounds)));
        let lattice = std::array::from_fn(|k| {
            let inner = nodes.iter().flat_map(Node::boxes).map(|(_, bounds)| bounds);
            let used = inner
                .chain(boxes.iter().copied())
                .flat_map(|row| [row.min[k], row.max[k]]);
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
    pub(crate) fn boxes_by_triangle(&self) -> BTreeMap<u32, Vec<ReferenceBoxRow>> {
        let mut out: BTreeMap<u32, Vec<ReferenceBoxRow>> = BTreeMap::new();
        for (triangle, bounds) in self.references.iter().zip(&self.boxes) {
            let boxes = out.entry(*triangle).or_default();
            if !boxes.contains(bounds) {
                boxes.push(*bounds);
            }
        }
        out
    }

    pub(crate) fn holds(&self, bounds: &ReferenceBoxRow, point: &Point) -> bool {
        (0..3).all(|k| {
            let plane = |q: u16| &self.lattice[k][&q];
            plane(bounds.min[k])[0] <= point[k] && point[k] <= plane(bounds.max[k])[1]
        })
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
