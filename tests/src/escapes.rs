//! The first proof obligation of the contract: every corner of every triangle in its box, widened by the pose's excess
//! and by nothing else, in exact arithmetic. Boxes that follow the pose are not widened at all.
//!
//! Written from `FORMAT.md`, sections 5.3 and 6.2 to 6.7; it shares no arithmetic with the baker or the runtime. There is
//! no division in it: with adj X the adjugate of a cluster frame's linear part, `X⁻¹v ≥ b` is `adj X·(v − t) ≥ b·det X` for
//! a positive determinant, and sums and products of floating-point numbers are exact in [`Dyadic`].

use crate::{
    Dyadic,
    followed_nodes::Followed,
    widened_tree::{Tree, Widened},
};
use restpose_formats::ModelView;
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

/// A point, in exact arithmetic.
pub(crate) type Point = [Dyadic; 3];

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
            scale: &frame.scale,
            excess: excess.map(Dyadic::from),
        };
        let followed = Followed::new(model, cluster, &frame, &posed.maps, &posed.morph_weights);
        let tree = Tree::new(model, cluster, &widened, &followed);
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

pub(crate) fn exact(point: [f32; 3]) -> Point {
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
pub(crate) struct Frame {
    /// Rows of the adjugate, its signs turned where the determinant is negative.
    adjugate: [Point; 3],
    translation: Point,
    /// The determinant's magnitude.
    pub(crate) scale: Dyadic,
}

impl Frame {
    pub(crate) fn new([x, y, z, translation]: &[Point; 4]) -> Self {
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
    pub(crate) fn scaled_fuzzy_position(&self, posed: &Point) -> Point {
        let from_origin = std::array::from_fn(|k| &posed[k] - &self.translation[k]);
        self.turned(&from_origin)
    }

    /// How a bone with this map moves against the cluster, times `scale`.
    pub(crate) fn scaled_motion(&self, [x, y, z, translation]: &[Point; 4]) -> Motion {
        let mut linear = [x, y, z].map(|column| self.turned(column));
        for (k, column) in linear.iter_mut().enumerate() {
            column[k] = &column[k] - &self.scale;
        }
        let away = std::array::from_fn(|k| &translation[k] - &self.translation[k]);
        Motion {
            linear,
            offset: self.turned(&away),
        }
    }

    fn turned(&self, vector: &Point) -> Point {
        self.adjugate.each_ref().map(|row| dot(row, vector))
    }
}

/// What a bone adds to a local point that follows it: `E·p + d`.
pub(crate) struct Motion {
    /// Columns of E.
    linear: [Point; 3],
    offset: Point,
}

impl Motion {
    pub(crate) fn of_point(&self, point: &Point) -> Point {
        let [x, y, z] = &self.linear;
        std::array::from_fn(|k| &dot(&[x[k].clone(), y[k].clone(), z[k].clone()], point) + &self.offset[k])
    }

    /// By how much E takes apart what is within these lengths, at most.
    pub(crate) fn of_half_sides(&self, half: &Point) -> Point {
        let [x, y, z] = &self.linear;
        std::array::from_fn(|k| dot(&[x[k].abs(), y[k].abs(), z[k].abs()], half))
    }
}

fn dot(a: &Point, b: &Point) -> Dyadic {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}
