//! Cluster frames: how a ray enters a cluster's local space, and by how much the cluster's boxes are widened there.
//!
//! # Why no hit is missed
//!
//! Notation: `q` is a vertex's fuzzy position, inside the cluster's fuzzy boxes; `X` the cluster frame's and `Xᵢ` the
//! other bones' maps from rest to world space as stored (`f32`); `v̂` the vertex as the vertex function computes it;
//! `x ↦ L(x − c_w) + c_l` the map into local space, its twelve `f32` numbers taken as exact. Bars are entry-wise
//! absolute values, u = 2⁻²⁴. The margin of a cluster for a ray is the sum of what can lie between the exact fuzzy
//! position and what traversal computes:
//!
//! 1. *Palette.* With an instance transform T, `X = fl(T·X°)` differs from the exact product by at most u·N, where
//!    N = |X| + 2⁻²⁴·|T||X°| also covers the `f64` arithmetic. Likewise each `Xᵢ`.
//! 2. *Vertex function.* `|v̂ − Σ w T Xᵢ° p| ≤ (u + γₙ)·E` with E the greatest `N·P` over the cluster's bones, P the
//!    greatest `|p|` that a bone moves. Weights sum to exactly one, so `Σ w T Xᵢ° p = T X° q`. A vertex of a cache is
//!    the same with two maps, those of its track at the keys around the frame, and their weights already in them: E is
//!    the sum of both `N·P`, P the greatest stored numbers. X° is then the bone's map times the blend of the cluster's
//!    own track, and q lies in the boxes for every blend (the baker's `key_boxes`).
//! 3. *Inverse.* `L(X q + t − c_w) + c_l = q + R(q)`, and R is evaluated after the fact, so nothing is assumed of how
//!    the inverse was found.
//! 4. *Pose.* In a pose outside those that the boxes were made for, q leaves its boxes by at most the pose's excess
//!    (`excess` holds the proof); the box of all of them is widened by it before anything else is derived from it.
//! 5. *Triangle test.* A hit is an exact hit of a triangle moved by [`VERTEX_ERROR`]·D per axis, D the greatest
//!    distance per axis from the ray's origin to the cluster's world box.
//! 6. *Ray.* Transforming origin and direction costs γ₅ and γ₃ times `|L|·D`, for `|t·d|∞ ≤ D` wherever the ray is
//!    inside the world box; plus u·|c_l|.
//! 7. *Slabs.* `((plane − o) ∓ margin)·(1/d)` has four roundings, 4u relative to `|plane − o|`.
//!
//! 1 to 4 make [`LocalFrame::margin_local`], fixed for the frame; 5 to 7 are [`RAY_ERROR`]`·D·Σ|L|` and a term in
//! the size of the local box, added when a ray enters. Boxes that follow the pose hold in every pose: for them
//! [`LocalFrame::margin_posed`] has what rounding adds to their planes (`mover_maps`) in place of point 4.
//!
//! Boxes of single triangles are on a lattice, and a plane at step q is computed as `q·(step·(1/d)) + ((min − o) ∓
//! margin)·(1/d)`: nine roundings, relative to `|min − o|` and the side of the box, which is at most twice its extent.
//! That is within the 4u relative to `|plane − o|` of point 7 and 32u of the extent.
//!
//! Based on: Higham, *Accuracy and Stability of Numerical Algorithms*, §3; Ize, *Robust BVH Ray Traversal*, JCGT 2(2),
//! 2013. Differs from Ize: he widens `t` of the far planes by 1 + 2γ; here the plane itself moves by an absolute
//! length, because the geometry, too, is uncertain by one.

use crate::triangle::VERTEX_ERROR;
use restpose_formats::{
    geom::{
        Aabb, Affine,
        round::{UNIT_ROUNDOFF, f32_above, f32_below, gamma},
    },
    rows::ReferenceBoxRow,
};

/// Cluster frames whose linear part has a greater condition number (Frobenius) are not inverted.
///
/// The margin grows with the condition number; at 2¹⁶ it reaches a tenth of the cluster's own size and tree traversal
/// stops paying.
const CONDITION_LIMIT: f64 = 65_536.0;

/// Cluster frames that scale by more than this, or by less than its inverse, are not inverted: products with their
/// entries could underflow to nothing and take the relative error bounds with them.
const SCALE_LIMIT: f64 = (1u64 << 60) as f64;

/// Beyond this a coordinate in local space, or its distance to another, may have overflowed to infinity: fuzzy boxes that
/// reach further are not used (their sides were cut off at `f32::MAX`), and ray origins beyond it are restricted by
/// nothing.
const EXTENT_LIMIT: f64 = (1u128 << 126) as f64;

/// Ray-dependent part of the margin, per unit of `Σ|L|·D`: triangle test 6u, ray transform γ₅ + γ₃ ≤ 8.1u, slabs 4u,
/// and the rounding of the margin itself; 24u covers them.
const RAY_ERROR: f32 = (VERTEX_ERROR + 18.0 * UNIT_ROUNDOFF) as f32;

/// The same in world space, where no ray is transformed: triangle test 6u, slabs 4u; 16u covers them.
pub(crate) const WORLD_RAY_ERROR: f32 = (VERTEX_ERROR + 10.0 * UNIT_ROUNDOFF) as f32;

/// 2⁻¹⁴⁰: covers what gradual underflow adds to the sums above, at most 2⁻¹⁵⁰ per operation. Taken once in local units
/// and once times `Σ|L|` for what underflows in world space.
const UNDERFLOW_FLOOR: f64 = 1.0 / (1u128 << 116) as f64 * UNIT_ROUNDOFF;

/// 2⁻¹²⁶. Below it a rounding is no longer relative to its number; adding it to a magnitude makes u times the magnitude
/// a bound again, for up to 2²⁴·2⁻¹⁵⁰.
pub(crate) const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;

/// 2⁻²⁴: times u it bounds the roundings of up to sixteen operations in `f64`, which a product of an instance transform,
/// a bone's map, a blend of two keys and a lattice stays below.
const F64_CHAIN: f64 = UNIT_ROUNDOFF;

/// Relative slack for sums that bound something in `f64`: a few hundred roundings of 2⁻⁵³.
const F64_SLACK: f64 = 1.0 / (1u64 << 44) as f64;

/// The inverse of a map's linear part in `f64`, rows first, if the map is usable as a cluster frame: finite, within
/// the limits of scale and condition.
///
/// The baker asks the same function which samples bound a cluster's boxes, so baker and runtime agree on which poses
/// the tree serves; for the others the runtime refits the tree.
#[must_use]
pub fn invert_frame(frame: &Affine) -> Option<[[f64; 3]; 3]> {
    let [c0, c1, c2] = [0, 1, 2].map(|k: usize| frame.columns[k].map(f64::from));
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let rows = [cross(c1, c2), cross(c2, c0), cross(c0, c1)];
    let determinant = c0[0] * rows[0][0] + c0[1] * rows[0][1] + c0[2] * rows[0][2];
    let inverse = rows.map(|row| row.map(|x| x / determinant));
    let norm = |m: [[f64; 3]; 3]| m.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
    let (forward, backward) = (norm([c0, c1, c2]), norm(inverse));
    let usable =
        frame.is_finite() && forward * backward <= CONDITION_LIMIT && forward <= SCALE_LIMIT && backward <= SCALE_LIMIT;
    usable.then_some(inverse)
}

/// An affine map in `f64`, with bounds of the magnitudes that entered its entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map64 {
    columns: [[f64; 3]; 4],
    magnitudes: [[f64; 3]; 4],
}

impl Map64 {
    /// A stored map, exactly.
    pub(crate) fn new(map: &Affine) -> Self {
        let columns = map.columns.map(|column| column.map(f64::from));
        let magnitudes = columns.map(|column| column.map(f64::abs));
        Self { columns, magnitudes }
    }

    /// `q ↦ origin + step·q`, exactly.
    pub(crate) fn lattice(origin: [f32; 3], step: f32) -> Self {
        Self::new(&Affine {
            columns: [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step], origin],
        })
    }

    /// `Σ weight·map` over two maps; weights are not negative.
    pub(crate) fn blend(weights: [f64; 2], maps: &[Self; 2]) -> Self {
        let mix = |of: fn(&Self) -> &[[f64; 3]; 4]| {
            let [a, b] = maps.each_ref().map(of);
            std::array::from_fn(|j| std::array::from_fn(|k| weights[0] * a[j][k] + weights[1] * b[j][k]))
        };
        Self {
            columns: mix(|map| &map.columns),
            magnitudes: mix(|map| &map.magnitudes),
        }
    }
}

/// `a` after `b`.
fn product(a: &Map64, b: &Map64) -> Map64 {
    Map64 {
        columns: columns_product(&a.columns, &b.columns),
        magnitudes: columns_product(&a.magnitudes, &b.magnitudes),
    }
}

#[inline]
fn columns_product(a: &[[f64; 3]; 4], b: &[[f64; 3]; 4]) -> [[f64; 3]; 4] {
    std::array::from_fn(|j| {
        std::array::from_fn(|k| {
            let offset = if j == 3 { a[3][k] } else { 0.0 };
            a[0][k] * b[j][0] + a[1][k] * b[j][1] + a[2][k] * b[j][2] + offset
        })
    })
}

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// The map of [`PosedMap::product`] alone, the same bits: what vertices are posed by.
#[inline]
pub(crate) fn posed_map(transform: &Map64, x: &Affine) -> Affine {
    if transform.columns == IDENTITY {
        return *x;
    }
    let columns = x.columns.map(|column| column.map(f64::from));
    let product = if columns == IDENTITY {
        transform.columns
    } else {
        columns_product(&transform.columns, &columns)
    };
    Affine {
        columns: product.map(|column| column.map(|entry| entry as f32)),
    }
}

/// A map to world space, rounded to `f32` once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedMap {
    pub map: Affine,
    /// N of point 1: bounds `|X|` and, times u, the error of X.
    magnitude: [[f64; 3]; 4],
}

impl PosedMap {
    pub(crate) const ZERO: Self = Self {
        map: Affine::IDENTITY,
        magnitude: [[0.0; 3]; 4],
    };

    /// The product of maps, the first one applied last.
    ///
    /// Complexity: identities are left out, which keeps them exact and the bound small.
    pub(crate) fn product(maps: &[&Map64]) -> Self {
        Self::weighted(1.0, maps)
    }

    /// `weight` times the product of maps: images of points are `weight` times theirs under the product.
    pub(crate) fn weighted(weight: f64, maps: &[&Map64]) -> Self {
        let mut chain = maps.iter().rev().filter(|map| map.columns != IDENTITY);
        let mut total = chain
            .next()
            .map_or_else(|| Map64::new(&Affine::IDENTITY), |last| **last);
        for map in chain {
            total = product(map, &total);
        }
        for entry in total.columns.iter_mut().chain(&mut total.magnitudes).flatten() {
            *entry *= weight;
        }
        let mut out = Self::ZERO;
        for j in 0..4 {
            for k in 0..3 {
                let rounded = total.columns[j][k] as f32;
                out.map.columns[j][k] = rounded;
                // A subnormal entry is rounded by up to 2⁻¹⁵⁰, which is u times the last term.
                out.magnitude[j][k] = f64::from(rounded.abs()) + total.magnitudes[j][k] * F64_CHAIN + SMALLEST_NORMAL;
            }
        }
        out
    }

    /// `N·(|p|, 1)` for points with `|p| ≤ extent`.
    pub(crate) fn reach(&self, extent: [f64; 3]) -> [f64; 3] {
        let m = &self.magnitude;
        std::array::from_fn(|k| m[0][k] * extent[0] + m[1][k] * extent[1] + m[2][k] * extent[2] + m[3][k])
    }
}

/// What [`PosedMap::reach`] of the product of a transform and a bone's map is, without that product: `posed` is its map. With
/// `|T||X|·p = |T|·(|X|·p)` a third of the multiplications are left.
///
/// It is E of point 2 but for the order of a dozen roundings in `f64`, each 2⁻⁵³ of a sum of positive numbers. The factor that
/// E gets, u + γₙ, has [`F64_SLACK`] of 2⁻⁴⁴ relatively for such ([`vertex_error`]).
#[inline]
pub(crate) fn posed_reach(transform: &Affine, x: &Affine, posed: &Affine, extent: [f64; 3]) -> [f64; 3] {
    let images = |map: &Affine, p: [f64; 3]| {
        let [a, b, c, d] = &map.columns;
        let row = |k: usize| {
            let entry = |column: &[f32; 3]| f64::from(column[k].abs());
            entry(a) * p[0] + entry(b) * p[1] + entry(c) * p[2] + entry(d)
        };
        [row(0), row(1), row(2)]
    };
    let entering = images(transform, images(x, extent));
    let reach = images(posed, extent);
    let smallest = SMALLEST_NORMAL * (extent[0] + extent[1] + extent[2] + 1.0);
    let bound = |k: usize| reach[k] + F64_CHAIN * entering[k] + smallest;
    [bound(0), bound(1), bound(2)]
}

/// A cluster in this frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClusterFrame {
    /// Contains every posed vertex of the cluster.
    pub bounds_world: Aabb,
    pub way: Way,
}

/// How a ray finds a cluster's triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Way {
    /// By the cluster's fuzzy tree, in local space.
    Local(LocalFrame),
    /// By a tree that was built for this pose: its place among the instance's.
    Posed(u32),
    /// By the topology of its fuzzy tree with the boxes of its posed triangles, in world space: where there is no usable
    /// inverse, or no fuzzy box holds.
    Refitted,
}

/// `x ↦ linear·(x − center_world) + center_local`, and the margins that go with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    /// Rows.
    linear: [[f32; 3]; 3],
    center_world: [f32; 3],
    center_local: [f32; 3],
    /// Points 1 to 4, and the terms of 6 and 7 in the size of the local box.
    margin_local: [f32; 3],
    /// The same for boxes that follow the pose, and so need no excess.
    margin_posed: [f32; 3],
    /// [`RAY_ERROR`]`·Σ|L|` per local axis.
    margin_per_distance: [f32; 3],
}

/// Range in which [`gamma`] is a bound.
const MOST_ROUNDINGS: u32 = 1 << 20;

/// What [`ClusterFrame::new`] needs.
pub(crate) struct FrameInputs<'a> {
    /// The cluster frame: world from local space.
    pub frame: &'a PosedMap,
    /// Box around the cluster's fuzzy boxes, local space.
    pub bounds_local: &'a Aabb,
    /// E of point 2.
    pub reach: [f64; 3],
    /// u + γₙ of the vertex function.
    pub vertex_error: f64,
    /// Contains every posed vertex of the cluster.
    pub bounds_world: &'a Aabb,
    /// Bounds, per local axis, by how much fuzzy positions leave the fuzzy boxes in this pose.
    pub excess: [f64; 3],
    /// Bounds, per local axis, by how much they leave the boxes that follow the pose ([`MoverMaps`]).
    ///
    /// [`MoverMaps`]: crate::mover_maps::MoverMaps
    pub posed_error: [f64; 3],
}

/// Relative error of the vertex function and of the palette entries that it reads, from
/// [`rounding_count`](crate::vertex::rounding_count).
///
/// Infinite, so that nothing is traced through a tree, where there are more roundings than γ is defined for.
pub(crate) fn vertex_error(roundings: u32) -> f64 {
    if roundings >= MOST_ROUNDINGS {
        return f64::INFINITY;
    }
    (UNIT_ROUNDOFF + gamma(roundings)) * (1.0 + F64_SLACK)
}

impl ClusterFrame {
    /// The frame of a cluster, or `None` where it has no usable inverse.
    pub(crate) fn new(inputs: &FrameInputs) -> Option<Self> {
        let frame = &inputs.frame.map;
        let inverse = invert_frame(frame)?;
        let x = frame.columns.map(|column| column.map(f64::from));
        let local = Extents::new(inputs.bounds_local).widened(inputs.excess);
        if !local.reach.iter().all(|x| *x <= EXTENT_LIMIT) {
            return None;
        }
        let extent = local.reach;
        let frame_reach = inputs.frame.reach(extent);
        // Points 1 and 2, per world axis.
        let vertex_error: [f64; 3] = std::array::from_fn(|k| {
            UNIT_ROUNDOFF * frame_reach[k] + inputs.vertex_error * inputs.reach[k] + UNDERFLOW_FLOOR
        });
        let bounds_world = overlap(local.world_box(inputs.frame, vertex_error), *inputs.bounds_world);
        let center = bounds_world.center();
        // Halving a subnormal can leave the box.
        let center_world: [f32; 3] =
            std::array::from_fn(|k| center[k].max(bounds_world.min[k]).min(bounds_world.max[k]));
        if !center_world.iter().all(|x| x.is_finite()) {
            return None;
        }

        let linear = inverse.map(|row| row.map(|entry| entry as f32));
        let l = linear.map(|row| row.map(f64::from));
        let from_origin: [f64; 3] = std::array::from_fn(|i| f64::from(center_world[i]) - x[3][i]);
        let center_local: [f32; 3] = std::array::from_fn(|k| {
            (inverse[k][0] * from_origin[0] + inverse[k][1] * from_origin[1] + inverse[k][2] * from_origin[2]) as f32
        });

        let mut margin_local = [0.0f32; 3];
        let mut margin_posed = [0.0f32; 3];
        let mut margin_per_distance = [0.0f32; 3];
        for k in 0..3 {
            // Point 3: R, its rounding in f64 bounded beside it.
            let (mut residual, mut rounding) = (0.0, 0.0);
            for j in 0..3 {
                let (product, bound) = dot_and_bound(l[k], x[j]);
                residual += (product - if j == k { 1.0 } else { 0.0 }).abs() * extent[j];
                rounding += (bound + 1.0) * extent[j];
            }
            let (offset, bound) = dot_and_bound(l[k], from_origin);
            residual += (f64::from(center_local[k]) - offset).abs();
            let origin_bound = dot_and_bound(
                l[k],
                std::array::from_fn(|i| f64::from(center_world[i]).abs() + x[3][i].abs()),
            )
            .1;
            rounding += bound + origin_bound + f64::from(center_local[k].abs());

            let (_, moved) = dot_and_bound(l[k], vertex_error);
            // |c_l| once in point 6; planes of the local box twice the extent in point 7.
            let box_rounding = 32.0 * UNIT_ROUNDOFF * (f64::from(center_local[k].abs()) + extent[k]);
            let scale = l[k][0].abs() + l[k][1].abs() + l[k][2].abs();
            let own = residual + moved + box_rounding + F64_SLACK * rounding + UNDERFLOW_FLOOR * (1.0 + scale);
            // The last factor: point 7 relative to the margin itself, and its sum with the ray's part.
            let rounded = |margin: f64| f32_above(margin * (1.0 + 8.0 * UNIT_ROUNDOFF));
            margin_local[k] = rounded(own + inputs.excess[k]);
            margin_posed[k] = rounded(own + inputs.posed_error[k]);
            margin_per_distance[k] = f32_above(f64::from(RAY_ERROR) * scale);
        }
        let local = LocalFrame {
            linear,
            center_world,
            center_local,
            margin_local,
            margin_posed,
            margin_per_distance,
        };
        let finite = local
            .margin_local
            .iter()
            .chain(&local.margin_per_distance)
            .all(|m| m.is_finite());
        finite.then_some(Self {
            bounds_world,
            way: Way::Local(local),
        })
    }
}

/// A box by its middle and half its sides, in `f64`.
struct Extents {
    center: [f64; 3],
    half: [f64; 3],
    /// Greatest magnitude per axis.
    reach: [f64; 3],
}

impl Extents {
    fn new(bounds: &Aabb) -> Self {
        let (min, max) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
        Self {
            center: std::array::from_fn(|k| 0.5 * (min[k] + max[k])),
            half: std::array::from_fn(|k| 0.5 * (max[k] - min[k])),
            reach: std::array::from_fn(|k| min[k].abs().max(max[k].abs())),
        }
    }

    /// The box widened by `excess` on both sides of each axis.
    fn widened(mut self, excess: [f64; 3]) -> Self {
        for k in 0..3 {
            self.half[k] += excess[k];
            self.reach[k] += excess[k];
        }
        self
    }

    /// The box around the image of this one, widened by `error`.
    fn world_box(&self, map: &PosedMap, error: [f64; 3]) -> Aabb {
        let x = map.map.columns.map(|column| column.map(f64::from));
        let reach = map.reach(self.reach);
        let mut out = Aabb::EMPTY;
        for k in 0..3 {
            let middle = x[0][k] * self.center[0] + x[1][k] * self.center[1] + x[2][k] * self.center[2] + x[3][k];
            let spread = x[0][k].abs() * self.half[0] + x[1][k].abs() * self.half[1] + x[2][k].abs() * self.half[2];
            let spread = spread + error[k] + F64_SLACK * reach[k];
            out.min[k] = f32_below(middle - spread);
            out.max[k] = f32_above(middle + spread);
        }
        out
    }
}

/// World box of what lies in `bounds` before `map`, in exact arithmetic, where vertices are off by `vertex_error` after it.
pub(crate) fn world_box(bounds: &Aabb, map: &PosedMap, vertex_error: [f64; 3]) -> Aabb {
    let bounds = Extents::new(bounds);
    let rounding = map.reach(bounds.reach);
    let error = std::array::from_fn(|k| vertex_error[k] + UNIT_ROUNDOFF * rounding[k] + UNDERFLOW_FLOOR);
    bounds.world_box(map, error)
}

/// What two boxes that both contain something have in common.
fn overlap(a: Aabb, b: Aabb) -> Aabb {
    let mut out = a;
    for k in 0..3 {
        let (min, max) = (a.min[k].max(b.min[k]), a.max[k].min(b.max[k]));
        if min <= max {
            (out.min[k], out.max[k]) = (min, max);
        }
    }
    out
}

/// `a·b` and `Σ|a||b|`.
fn dot_and_bound(a: [f64; 3], b: [f64; 3]) -> (f64, f64) {
    let products: [f64; 3] = std::array::from_fn(|i| a[i] * b[i]);
    (products.iter().sum(), products.iter().map(|p| p.abs()).sum())
}

/// A ray ready for slab tests and kd-tree steps: the space it is in, and by how much planes are widened there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay {
    pub origin: [f32; 3],
    pub inverse_direction: [f32; 3],
    /// Each plane counts from this much before it to this much behind it.
    pub margin: [f32; 3],
}

/// The greatest distance per axis from `origin` to a point of `bounds`.
fn distance(origin: [f32; 3], bounds: &Aabb) -> f32 {
    (0..3).fold(0.0, |far: f32, k| {
        far.max(bounds.max[k] - origin[k]).max(origin[k] - bounds.min[k])
    })
}

impl SlabRay {
    /// The ray in world space, with the margin that boxes inside `bounds` need (points 5 and 7).
    pub(crate) fn in_world(origin: [f32; 3], direction: [f32; 3], bounds: &Aabb) -> Self {
        let margin = WORLD_RAY_ERROR * distance(origin, bounds) + UNDERFLOW_FLOOR as f32;
        Self {
            origin,
            inverse_direction: std::array::from_fn(|k| 1.0 / direction[k]),
            margin: [margin; 3],
        }
    }

    /// Where the ray may be inside `bounds`, within `range`; `None` when it is nowhere.
    ///
    /// Comparisons are written so that a NaN (a ray in the plane of a face, an overflown margin) restricts nothing.
    #[inline]
    pub(crate) fn clip(&self, bounds: &Aabb, range: (f32, f32)) -> Option<(f32, f32)> {
        let (mut enter, mut exit) = range;
        for k in 0..3 {
            let low = ((bounds.min[k] - self.origin[k]) - self.margin[k]) * self.inverse_direction[k];
            let high = ((bounds.max[k] - self.origin[k]) + self.margin[k]) * self.inverse_direction[k];
            let (near, far) = if self.inverse_direction[k].is_sign_positive() {
                (low, high)
            } else {
                (high, low)
            };
            if near > enter {
                enter = near;
            }
            if far < exit {
                exit = far;
            }
        }
        (enter <= exit).then_some((enter, exit))
    }
}

/// A ray ready for the boxes of single triangles: where along it the planes of a cluster's lattice lie.
///
/// Of the two planes of an axis, `near` is the one that the ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LatticeRay {
    /// `t` per lattice step.
    pub rate: [f32; 3],
    /// `t` of the lattice's zero, widened for near planes.
    pub near: [f32; 3],
    /// The same for far planes.
    pub far: [f32; 3],
    /// Whether the ray runs with the axis.
    pub forward: [bool; 3],
}

impl LatticeRay {
    /// `steps` are those of [`restpose_formats::rows::box_steps`]. Along an axis where a plane's `t` could overflow, or
    /// its rate is so small that rounding is no longer relative to it, boxes restrict nothing.
    #[inline]
    pub(crate) fn new(ray: &SlabRay, bounds: &Aabb, steps: &[f32; 3]) -> Self {
        Self::within(ray, bounds.min, *steps, f32::from(u16::MAX))
    }

    /// As [`LatticeRay::new`], for planes that are up to so many steps from the lattice's zero.
    #[inline]
    pub(crate) fn within(ray: &SlabRay, zero: [f32; 3], steps: [f32; 3], most_steps: f32) -> Self {
        let forward = ray.inverse_direction.map(f32::is_sign_positive);
        let plane = |k: usize, towards_max: bool| {
            let relative = zero[k] - ray.origin[k];
            let widened = if towards_max {
                relative + ray.margin[k]
            } else {
                relative - ray.margin[k]
            };
            widened * ray.inverse_direction[k]
        };
        let mut out = Self {
            rate: std::array::from_fn(|k| steps[k] * ray.inverse_direction[k]),
            near: std::array::from_fn(|k| plane(k, !forward[k])),
            far: std::array::from_fn(|k| plane(k, forward[k])),
            forward,
        };
        for k in 0..3 {
            let rate = out.rate[k].abs();
            let small = |t: f32| t.abs() < f32::MAX / 4.0;
            let in_range = small(out.near[k]) && small(out.far[k]) && small(most_steps * rate);
            let precise = rate >= f32::MIN_POSITIVE || steps[k] == 0.0;
            if !(in_range && precise) {
                out.rate[k] = f32::NAN;
            }
        }
        out
    }

    /// Whether the ray may be inside the box within `range`. A NaN restricts nothing.
    #[inline]
    pub(crate) fn meets(&self, bounds: &ReferenceBoxRow, range: (f32, f32)) -> bool {
        let (mut enter, mut exit) = range;
        for k in 0..3 {
            let (near, far) = if self.forward[k] {
                (bounds.min[k], bounds.max[k])
            } else {
                (bounds.max[k], bounds.min[k])
            };
            let near = f32::from(near) * self.rate[k] + self.near[k];
            let far = f32::from(far) * self.rate[k] + self.far[k];
            enter = if near > enter { near } else { enter };
            exit = if far < exit { far } else { exit };
        }
        enter <= exit
    }
}

impl LocalFrame {
    /// The ray in local space, with this cluster's margin for it, and the margin for boxes that follow the pose. `t` is the
    /// same in both spaces.
    #[inline]
    pub(crate) fn enter(&self, origin: [f32; 3], direction: [f32; 3], bounds_world: &Aabb) -> (SlabRay, [f32; 3]) {
        let from_center: [f32; 3] = std::array::from_fn(|k| origin[k] - self.center_world[k]);
        let product = |v: [f32; 3], k: usize| {
            let row = self.linear[k];
            (row[0] * v[0] + row[1] * v[1]) + row[2] * v[2]
        };
        let far = distance(origin, bounds_world);
        let origin: [f32; 3] = std::array::from_fn(|k| product(from_center, k) + self.center_local[k]);
        // Where the origin, or its distance to a plane, may have overflowed, no plane restricts the ray.
        let with = |own: &[f32; 3], k: usize| {
            if origin[k].abs() <= EXTENT_LIMIT as f32 {
                own[k] + self.margin_per_distance[k] * far
            } else {
                f32::INFINITY
            }
        };
        let ray = SlabRay {
            origin,
            inverse_direction: std::array::from_fn(|k| 1.0 / product(direction, k)),
            margin: std::array::from_fn(|k| with(&self.margin_local, k)),
        };
        (ray, std::array::from_fn(|k| with(&self.margin_posed, k)))
    }

    /// The largest part of the margin that does not depend on the ray, relative to nothing: local units.
    pub(crate) fn largest_margin(&self) -> f32 {
        self.margin_local.iter().fold(0.0, |largest: f32, m| largest.max(*m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reach of a product, by two ways.
    #[test]
    fn reach_needs_no_product() {
        let mut random = fastrand::Rng::with_seed(9);
        for round in 0..20_000 {
            let mut map = |identity: bool| {
                if identity {
                    return Affine::IDENTITY;
                }
                let scale = 10f32.powi(random.i32(-20..18));
                let mut column = || std::array::from_fn(|_| (random.f32() - 0.5) * scale);
                Affine {
                    columns: std::array::from_fn(|_| column()),
                }
            };
            let (transform, x) = (map(round % 5 == 0), map(round % 7 == 0));
            let extent: [f64; 3] = std::array::from_fn(|_| random.f64() * 10f64.powi(random.i32(-9..9)));
            let product = PosedMap::product(&[&Map64::new(&transform), &Map64::new(&x)]);
            let posed = posed_map(&Map64::new(&transform), &x);
            assert_eq!(posed, product.map);
            let (expected, found) = (product.reach(extent), posed_reach(&transform, &x, &posed, extent));
            for k in 0..3 {
                // A dozen roundings each.
                let difference = (found[k] - expected[k]).abs();
                assert!(
                    difference <= 32.0 * f64::EPSILON * expected[k],
                    "{round}: {found:?} {expected:?}"
                );
            }
        }
    }

    /// What enters counts where products cancel: the map alone does not tell.
    #[test]
    fn reach_counts_what_cancels() {
        let shift = |by: f32| Affine {
            columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [by, 0.0, 0.0]],
        };
        let (transform, x) = (shift(1e6), shift(-1e6));
        let posed = posed_map(&Map64::new(&transform), &x);
        assert_eq!(posed, Affine::IDENTITY);
        let reach = posed_reach(&transform, &x, &posed, [1.0; 3]);
        assert!(
            reach[0] > 1.0 + 2e6 * F64_CHAIN * 0.99 && reach[1] < 1.0 + 1e-6,
            "{reach:?}"
        );
    }

    /// Points on a ray, in boxes on the lattice that hold nothing else: all are met, at any scale of box and direction.
    #[test]
    fn a_box_around_a_point_of_the_ray_is_met() {
        let mut random = fastrand::Rng::with_seed(5);
        for round in 0..200_000 {
            let mut exponent = |range: i32| (random.f64() * 2.0 - 1.0) * f64::from(range);
            let (size, speed) = (exponent(36), exponent(37));
            let (size, speed) = (10f64.powf(size), 10f64.powf(speed));
            let mut signed = || random.f64() * 2.0 - 1.0;
            let point: [f64; 3] = std::array::from_fn(|_| signed() * size);
            let direction: [f32; 3] = std::array::from_fn(|_| {
                let d = signed();
                if d.abs() < 0.1 { 0.0 } else { (d * speed) as f32 }
            });
            let far = 4.0 * size / speed * signed();
            let origin: [f32; 3] = std::array::from_fn(|k| (point[k] - far * f64::from(direction[k])) as f32);
            let bounds = Aabb {
                min: [(-size) as f32; 3],
                max: [size as f32; 3],
            };
            if !origin
                .iter()
                .chain(&bounds.max)
                .all(|x| x.is_finite() && x.abs() < 1e37)
            {
                continue;
            }
            let fuzzy = Aabb::around([point.map(|x| x as f32)]);
            let margin = std::array::from_fn(|k: usize| {
                let reach = f64::from(origin[k].abs()) + 6.0 * size;
                f32_above(64.0 * UNIT_ROUNDOFF * reach + 2.0 * SMALLEST_NORMAL * (1.0 + speed))
            });
            let ray = SlabRay {
                origin,
                inverse_direction: std::array::from_fn(|k| 1.0 / direction[k]),
                margin,
            };
            let lattice = LatticeRay::new(&ray, &bounds, &restpose_formats::rows::box_steps(&bounds));
            let row = ReferenceBoxRow::around(&fuzzy, &bounds);
            let limit = [f32::INFINITY, f32::MAX][round % 2];
            assert!(
                lattice.meets(&row, (-limit, limit)),
                "round {round}: {ray:?} {bounds:?} {fuzzy:?}"
            );
        }
    }
}
