//! The first proof obligation of the contract: every corner of every triangle in its box, widened by the pose's excess
//! and by nothing else, in exact arithmetic.
//!
//! Written from `FORMAT.md`, sections 5.3 and 6.2 to 6.7; it shares no arithmetic with the baker or the runtime. There is
//! no division in it: with adj X the adjugate of a cluster frame's linear part, `X⁻¹v ≥ b` is `adj X·(v − t) ≥ b·det X` for
//! a positive determinant, and sums and products of floating-point numbers are exact in [`Dyadic`].

use crate::Dyadic;
use restpose_formats::{
    ModelView,
    rows::{ClusterRow, KdNode, ReferenceBoxRow, box_steps},
};
use restpose_runtime::Affine;
use std::collections::BTreeMap;

/// What a vertex has left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Escaped {
    /// The box of its triangle in a leaf.
    ReferenceBox,
    /// The bounds of its cluster.
    Bounds,
    /// The leaves that list its triangle: descending from the root to where the vertex is meets none of them.
    Tree,
}

/// A vertex that is not where the file says that it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Escape {
    /// Cluster row.
    pub cluster: u32,
    /// Triangle row.
    pub triangle: u32,
    /// Vertex row.
    pub vertex: u32,
    /// What it has left.
    pub from: Escaped,
}

type Point = [Dyadic; 3];

/// All escapes of the pose from the clusters of `excess`: cluster rows without a track and with an invertible frame, each
/// with the length per local axis by which its boxes and planes are widened, as
/// [`ClusterBounds::excess`](restpose_runtime::ClusterBounds::excess) has it.
///
/// Space: poses are in asset space, without an instance transform.
///
/// # Panics
/// When a frame has no inverse or a number is not finite.
#[must_use]
pub fn escapes(
    model: &ModelView,
    palette: &[Affine],
    morph_weights: &[f32],
    excess: impl IntoIterator<Item = (u32, [f64; 3])>,
) -> Vec<Escape> {
    let mut posed = Posed {
        model,
        maps: palette.iter().map(|map| map.columns.map(exact)).collect(),
        morph_weights: morph_weights.iter().map(|weight| Dyadic::from(*weight)).collect(),
        vertices: BTreeMap::new(),
    };
    let mut out = Vec::new();
    for (row, excess) in excess {
        let cluster = &model.clusters[row as usize];
        let frame = Frame::new(&posed.maps[cluster.bone as usize]);
        let widened = Widened {
            frame: &frame,
            excess: excess.map(Dyadic::from),
        };
        let tree = Tree::new(model, cluster, &widened);
        let mut fuzzy: BTreeMap<u32, Point> = BTreeMap::new();
        for (triangle, boxes) in tree.boxes_by_triangle() {
            for vertex in model.triangles[triangle as usize].corners {
                let point = fuzzy
                    .entry(vertex)
                    .or_insert_with(|| frame.scaled_fuzzy_position(posed.vertex(vertex)));
                let mut add = |from: Escaped| {
                    let cluster = row;
                    out.push(Escape {
                        cluster,
                        triangle,
                        vertex,
                        from,
                    });
                };
                if !boxes.iter().all(|bounds| tree.holds(bounds, point)) {
                    add(Escaped::ReferenceBox);
                }
                if !tree.bounds_hold(point) {
                    add(Escaped::Bounds);
                }
                if !tree.finds(triangle, point) {
                    add(Escaped::Tree);
                }
            }
        }
    }
    out
}

fn exact(point: [f32; 3]) -> Point {
    point.map(Dyadic::from)
}

struct Posed<'a> {
    model: &'a ModelView<'a>,
    /// Columns.
    maps: Vec<[Point; 4]>,
    morph_weights: Vec<Dyadic>,
    vertices: BTreeMap<u32, Point>,
}

impl Posed<'_> {
    /// `Σ w·X·(p + Σ μ·delta)`.
    fn vertex(&mut self, vertex: u32) -> &Point {
        let (model, maps, weights) = (self.model, &self.maps, &self.morph_weights);
        self.vertices.entry(vertex).or_insert_with(|| {
            let mut morphed = exact(model.vertices[vertex as usize].position_rest);
            for delta in model.morph_deltas_of(vertex as usize) {
                let by = exact(delta.delta);
                morphed = std::array::from_fn(|k| &morphed[k] + &(&weights[delta.target as usize] * &by[k]));
            }
            let mut posed: Point = std::array::from_fn(|_| Dyadic::zero());
            for influence in model.influences_of(vertex as usize) {
                let ([x, y, z, t], weight) = (&maps[influence.bone as usize], Dyadic::from(influence.weight));
                posed = std::array::from_fn(|k| {
                    let turned = &(&(&x[k] * &morphed[0]) + &(&y[k] * &morphed[1])) + &(&z[k] * &morphed[2]);
                    &posed[k] + &(&weight * &(&turned + &t[k]))
                });
            }
            posed
        })
    }
}

/// A cluster frame.
struct Frame {
    /// Rows of the adjugate, its signs turned where the determinant is negative.
    adjugate: [Point; 3],
    translation: Point,
    /// The determinant's magnitude.
    scale: Dyadic,
}

impl Frame {
    fn new([x, y, z, translation]: &[Point; 4]) -> Self {
        let cross = |a: &Point, b: &Point| -> Point {
            let minor = |i: usize, j: usize| &(&a[i] * &b[j]) - &(&a[j] * &b[i]);
            [minor(1, 2), minor(2, 0), minor(0, 1)]
        };
        let mut adjugate = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = dot(&adjugate[0], x);
        assert!(!determinant.is_zero(), "the frame has no inverse");
        if determinant.is_negative() {
            adjugate = adjugate.map(|row| row.map(|entry| -&entry));
        }
        Self {
            adjugate,
            translation: translation.clone(),
            scale: determinant.abs(),
        }
    }

    /// The fuzzy position of a posed vertex, times `scale`.
    fn scaled_fuzzy_position(&self, posed: &Point) -> Point {
        let from_origin = std::array::from_fn(|k| &posed[k] - &self.translation[k]);
        self.adjugate.each_ref().map(|row| dot(row, &from_origin))
    }
}

fn dot(a: &Point, b: &Point) -> Dyadic {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

/// Turns planes in a cluster's local space into what scaled fuzzy positions are compared with.
struct Widened<'a> {
    frame: &'a Frame,
    excess: Point,
}

impl Widened<'_> {
    /// The plane moved by the excess, downwards and upwards.
    fn plane(&self, axis: usize, at: &Dyadic) -> [Dyadic; 2] {
        let (scale, excess) = (&self.frame.scale, &self.excess[axis]);
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
}

/// A fuzzy tree, its planes and boxes widened.
struct Tree<'a> {
    references: &'a [u32],
    boxes: &'a [ReferenceBoxRow],
    /// Per axis the planes of the lattice that boxes use, by coordinate: widened downwards and upwards.
    lattice: [BTreeMap<u16, [Dyadic; 2]>; 3],
    /// Per axis.
    bounds: [[Dyadic; 2]; 3],
    nodes: Vec<Node>,
}

impl<'a> Tree<'a> {
    fn new(model: &ModelView<'a>, cluster: &ClusterRow, widened: &Widened) -> Self {
        let bounds = &cluster.bounds_local;
        let references = cluster.reference_first as usize..(cluster.reference_first + cluster.reference_count) as usize;
        let boxes = &model.reference_boxes[references.clone()];
        // The step's own arithmetic is part of the format (6.6).
        let (min, step) = (exact(bounds.min), exact(box_steps(bounds)));
        let lattice = std::array::from_fn(|k| {
            let used = boxes.iter().flat_map(|row| [row.min[k], row.max[k]]);
            let plane = |q: u16| widened.plane(k, &(&min[k] + &(&step[k] * &Dyadic::from(f64::from(q)))));
            used.map(|q| (q, plane(q))).collect()
        });
        let rows = &model.kd_nodes[cluster.node_first as usize..][..cluster.node_count as usize];
        let node = |row: KdNode| match row {
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
        Self {
            references: &model.references[references],
            boxes,
            lattice,
            bounds: std::array::from_fn(|k| {
                let [low, _] = widened.plane(k, &Dyadic::from(bounds.min[k]));
                let [_, high] = widened.plane(k, &Dyadic::from(bounds.max[k]));
                [low, high]
            }),
            nodes: rows.iter().map(|row| node(row.unpack())).collect(),
        }
    }

    /// Triangles, ascending, each with the different boxes that leaves have of it.
    fn boxes_by_triangle(&self) -> BTreeMap<u32, Vec<ReferenceBoxRow>> {
        let mut out: BTreeMap<u32, Vec<ReferenceBoxRow>> = BTreeMap::new();
        for (triangle, bounds) in self.references.iter().zip(self.boxes) {
            let boxes = out.entry(*triangle).or_default();
            if !boxes.contains(bounds) {
                boxes.push(*bounds);
            }
        }
        out
    }

    fn holds(&self, bounds: &ReferenceBoxRow, point: &Point) -> bool {
        (0..3).all(|k| {
            let plane = |q: u16| &self.lattice[k][&q];
            plane(bounds.min[k])[0] <= point[k] && point[k] <= plane(bounds.max[k])[1]
        })
    }

    fn bounds_hold(&self, point: &Point) -> bool {
        (0..3).all(|k| self.bounds[k][0] <= point[k] && point[k] <= self.bounds[k][1])
    }

    fn finds(&self, triangle: u32, point: &Point) -> bool {
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            match &self.nodes[node] {
                Node::Leaf { first, count } => {
                    if self.references[*first..][..*count].contains(&triangle) {
                        return true;
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
