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
//!    own track, and q lies in the boxes for every blend (the baker's `key_track`).
//! 3. *Inverse.* `L(X q + t − c_w) + c_l = q + R(q)`, and R is evaluated after the fact, so nothing is assumed of how
//!    the inverse was found.
//! 4. *Pose.* In a pose outside those that the boxes were made for, q leaves its boxes by at most the pose's excess
//!    (`excess` holds the proof); the box of all of them is widened by it before anything else is derived from it.
//! 5. *Triangle test.* A hit is an exact hit of a triangle moved by [`VERTEX_ERROR`]·D per axis, D the greatest
//!    distance per axis from the ray's origin to the cluster's world box.
//! 6. *Ray.* Transforming origin and direction costs γ₅ and γ₃ times `|L|·D`, for `|t·d|∞ ≤ D` wherever the ray is
//!    inside the world box; plus u·|c_l|. A component of the local direction that is shorter than u·Σ|L| is lengthened to
//!    that. The longest component of d is at least one, so `|t| ≤ D` there, and the ray moves by at most u·Σ|L|·D.
//! 7. *Slabs.* `((plane − o) ∓ margin)·(1/d)` has four roundings, 4u relative to `|plane − o|`.
//!
//! 1 to 4 make [`LocalFrame::margin_local`], fixed for the frame; 5 to 7 are [`local_frame::RAY_ERROR`]`·D·Σ|L|` and a term in
//! the size of the local box, added when a ray enters. Boxes that follow the pose hold in every pose: for them
//! [`LocalFrame::margin_posed`] has what rounding adds to their planes (`mover_maps`) in place of point 4.
//!
//! Boxes of single triangles are on a lattice, and a plane at step q is computed as `q·(step·(1/d)) + ((min − o) ∓
//! margin)·(1/d)`: nine roundings, relative to `|min − o|` and the side of the box, which is at most twice its extent.
//! That is within the 4u relative to `|plane − o|` of point 7 and 32u of the extent. Where q itself lies between those of two
//! keys, sides are up to 239/223 as long and q has eight roundings more, five of up to 239/223 sides and three of up to
//! 255/223, with the weight's two: 24u of the extent. What the nine roundings really take is less than half of their 32u, so
//! 48u hold both.
//!
//! Based on: Higham, *Accuracy and Stability of Numerical Algorithms*, §3; Ize, *Robust BVH Ray Traversal*, JCGT 2(2),
//! 2013. Differs from Ize: he widens `t` of the far planes by 1 + 2γ; here the plane itself moves by an absolute
//! length, because the geometry, too, is uncertain by one.

mod extents;
mod inverse;
mod lattice_ray;
mod local_frame;
mod posed_map;
mod slab_ray;

pub use inverse::invert_frame;

pub(crate) use extents::world_box;
pub(crate) use lattice_ray::LatticeRay;
pub(crate) use local_frame::{BundleFrame, LocalFrame};
pub(crate) use posed_map::{Entering, Map64, PosedMap};
pub(crate) use slab_ray::{SlabLanes, SlabRay};

use crate::{
    simd::{Doubles, Lanes},
    triangle::VERTEX_ERROR,
};
use extents::{Extents, overlap};
use restpose_formats::geom::{
    Aabb,
    round::{UNIT_ROUNDOFF, gamma},
};

/// Beyond this a coordinate in local space, or its distance to another, may have overflowed to infinity: fuzzy boxes that
/// reach further are not used (their sides were cut off at `f32::MAX`), and ray origins beyond it are restricted by
/// nothing.
pub(crate) const EXTENT_LIMIT: f64 = (1u128 << 126) as f64;

/// [`local_frame::RAY_ERROR`] in world space, where no ray is transformed: triangle test 6u, slabs 4u, and in bundles directions that are
/// lengthened 2u; 16u covers them.
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

/// Range in which [`gamma`] is a bound.
const MOST_ROUNDINGS: u32 = 1 << 20;

/// What [`ClusterFrame::new`] needs.
pub(crate) struct FrameInputs<'a, S: Lanes> {
    /// The cluster frame: world from local space.
    pub frame: &'a PosedMap,
    /// Box around the cluster's fuzzy boxes, local space.
    pub bounds_local: &'a Aabb,
    /// E of point 2, per world axis.
    pub reach: Doubles<S>,
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
    #[inline(always)]
    pub(crate) fn new<S: Lanes>(simd: S, inputs: &FrameInputs<S>) -> Option<Self> {
        let inverse = invert_frame(&inputs.frame.map)?;
        let local = Extents::new(inputs.bounds_local).widened(inputs.excess);
        let extent = local.reach;
        if !(extent[0] <= EXTENT_LIMIT && extent[1] <= EXTENT_LIMIT && extent[2] <= EXTENT_LIMIT) {
            return None;
        }
        let reach = inputs.frame.reach(simd, extent);
        // Points 1 and 2, per world axis.
        let floor = Doubles::splat(simd, UNDERFLOW_FLOOR);
        let vertex_error = reach * UNIT_ROUNDOFF + inputs.reach * inputs.vertex_error + floor;
        let bounds_world = local.world_box(simd, inputs.frame, reach, vertex_error);
        let bounds_world = overlap(bounds_world, *inputs.bounds_world);
        let local = LocalFrame::new(simd, inputs, &inverse, extent, vertex_error, &bounds_world)?;
        Some(Self {
            bounds_world,
            way: Way::Local(local),
        })
    }
}
