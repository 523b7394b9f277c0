//! Traversal: a hierarchy over the clusters' world boxes, and in each cluster that a ray enters, its fuzzy tree: a
//! kd-tree, or a wide one, some of whose boxes follow the pose.
//!
//! A ray is a state machine over these trees ([`flight`]): one alone goes from its begin to its end, those of a batch that no
//! bundle takes take turns where they wait for memory ([`fly()`]).
//!
//! Coherent rays of a batch go together as a [`bundle`]: through the tree over instances, and in each of these through the one
//! over all of its posed triangles ([`whole_tree`]), or through its clusters ([`clusters_together`]) and their trees
//! ([`fuzzy_tree`]), where a box is made and a triangle posed once for all of them. Those that part from their bundle there pass
//! what is below one after the other ([`lone_rays`]).
//!
//! Inside, the ray is `origin + t·2^e·direction'` with the direction scaled by a power of two so that its longest
//! component is in [1, 2): `t` then measures lengths, whatever the caller's units, and error bounds in lengths hold.
//! Ranges of `t` are cut one `f32` outside the hit's own `t`, so that its rounding never hides a hit.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.2.3 (two levels, triangle tests in world space). Differs: every
//! plane is widened by the cluster's margin for the ray (see `cluster_frame`), so the children of a node overlap.

mod batch;
mod binary_trees;
mod bundle;
mod clusters_together;
mod context;
mod flight;
mod fly;
mod fuzzy_tree;
mod lone_rays;
mod mailbox;
mod moments;
mod ray_order;
mod sorted_rays;
mod traveller;
mod walk;
mod whole_tree;

pub(crate) use batch::{Answer, trace_together};
pub(crate) use context::TraceContext;
pub(crate) use ray_order::{RayOrder, place};
pub(crate) use sorted_rays::trace_sorted;
pub(crate) use walk::Hierarchy;

use crate::{Hit, InstanceId, Ray, scene::Scene, stats::Count};
use fly::{Departure, Rays, fly};
use traveller::Traveller;

/// The closest hit, or any hit if `ANY`, at a time of the scene's interval from 0 to 1.
pub(crate) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    time: f32,
    context: &mut TraceContext,
    counters: &mut impl Count,
) -> Option<Hit> {
    trace_among::<ANY>(scene, ray, time, &|_| true, context, counters)
}

/// As [`trace`], among the instances for which `accept` is true.
pub(crate) fn trace_among<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    time: f32,
    accept: &impl Fn(InstanceId) -> bool,
    context: &mut TraceContext,
    counters: &mut impl Count,
) -> Option<Hit> {
    counters.ray();
    let ray = Some(Traveller::new(ray)?);
    if scene.top_level.bounds().is_empty() {
        return None;
    }
    let mut one = One {
        ray,
        accept,
        best: None,
    };
    fly::<ANY, 1, _, _>(
        scene,
        Departure::Scene { node: 0 },
        time,
        &mut one,
        &mut context.flight,
        counters,
    );
    one.best
}

/// A ray, among some instances.
struct One<'a, A> {
    /// The ray, and the scaled `t` at which it begins.
    ray: Option<(Traveller, f32)>,
    accept: &'a A,
    best: Option<Hit>,
}

impl<A: Fn(InstanceId) -> bool> Rays for One<'_, A> {
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, Traveller, f32)> {
        self.ray.take().map(|(traveller, start)| (0, traveller, start))
    }

    #[inline(always)]
    fn landed(&mut self, _place: usize, traveller: &Traveller) {
        self.best = traveller.best;
    }

    #[inline(always)]
    fn accepts(&self, instance: InstanceId) -> bool {
        (self.accept)(instance)
    }
}
