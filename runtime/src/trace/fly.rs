use super::{
    binary_trees::pass_geometry,
    context::FlightContext,
    flight::{Actor, Flight, Inside, Next},
    traveller::Traveller,
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, InstanceId,
    asset_instance::AssetInstance,
    cluster_frame::SlabRay,
    instance::Instance,
    scene::Scene,
    simd::{Lanes, Portable, SimdLevel, prefetch},
    stats::Count,
    wide::{WideNode, WideRay},
};

/// Rays that are on their way at once where many are to be traced: through a whole of 147k triangles random ones take 0.73 us each
/// one by one, 0.61 in twos, 0.57 in fours and in eights, between which this is, 0.60 in sixteens.
pub(super) const IN_FLIGHT: usize = 6;

/// Where rays come from, and where their hits go.
pub(super) trait Rays {
    /// The next ray: its place among them, the ray, and the scaled `t` at which it begins.
    fn next(&mut self) -> Option<(usize, Traveller, f32)>;

    /// A ray has been traced.
    fn landed(&mut self, place: usize, traveller: &Traveller);

    /// Whether rays may hit an instance.
    fn accepts(&self, _instance: InstanceId) -> bool {
        true
    }
}

/// Where rays set out.
#[derive(Clone, Copy)]
pub(super) enum Departure {
    /// At a node of the tree over instances.
    Scene { node: u32 },
    /// In an instance.
    Instance { index: u32, inside: Inside },
}

/// Traces rays, `N` of them in flight at a time, at a time of the scene's interval from 0 to 1: each ends at its closest hit,
/// or at any if `ANY`. While one waits for memory, others go on.
///
/// The tree over instances is not empty.
///
/// Based on: Psaropoulos et al., *Interleaving with Coroutines*, PVLDB 11(2), 2017: lookups in an index take turns at cache misses.
/// Differs: rays for lookups, and states written down for coroutines.
pub(super) fn fly<const ANY: bool, const N: usize, R: Rays, C: Count>(
    scene: &Scene,
    departure: Departure,
    time: f32,
    rays: &mut R,
    context: &mut FlightContext,
    counters: &mut C,
) {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (scene.simd, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled<const ANY: bool, const N: usize, R: Rays, C: Count>(
            simd: Avx2,
            scene: &Scene,
            departure: Departure,
            time: f32,
            rays: &mut R,
            context: &mut FlightContext,
            counters: &mut C,
        ) {
            fly_with::<ANY, N, _, R, C>(simd, scene, departure, time, rays, context, counters);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled::<ANY, N, R, C>(simd, scene, departure, time, rays, context, counters) };
    }
    fly_with::<ANY, N, _, R, C>(Portable, scene, departure, time, rays, context, counters);
}

#[inline(always)]
fn fly_with<const ANY: bool, const N: usize, S: Lanes, R: Rays, C: Count>(
    simd: S,
    scene: &Scene,
    departure: Departure,
    time: f32,
    rays: &mut R,
    context: &mut FlightContext,
    counters: &mut C,
) {
    let (nodes, bounds) = (scene.top_level.nodes(), scene.top_level.bounds());
    let mut flights = [const { None }; N];
    let mut places = [0; N];
    let mut in_flight = 0;
    let mut may_begin = true;
    loop {
        for slot in 0..N {
            if flights[slot].is_none() {
                if !may_begin {
                    continue;
                }
                let Some((place, traveller, start)) = rays.next() else {
                    may_begin = false;
                    continue;
                };
                places[slot] = place;
                flights[slot] = Some(begin(traveller, start, departure, nodes, &bounds));
                in_flight += 1;
            }
            let Some(flight) = &mut flights[slot] else { continue };
            if let Next::FindInstance(index) = flight.next {
                if let Some(Instance::Asset(instance)) = scene.in_slot(index)
                    && let Some(prepared) = instance.prepared_so_far()
                {
                    prefetch(std::slice::from_ref(prepared));
                }
                flight.next = Next::EnterInstance(index);
                continue;
            }
            let is_flying = if let Next::EnterInstance(index) = flight.next {
                flight.next = Next::TakePending;
                let accepts = rays.accepts(scene.id(index));
                let inside = match departure {
                    Departure::Instance { inside, .. } => inside,
                    Departure::Scene { .. } => Inside::All,
                };
                let place = (index, inside);
                !(accepts && enter_instance::<ANY, S, C>(simd, scene, place, time, flight, context, counters))
            } else {
                flight.step::<ANY, S, C>(simd, &mut context.stacks[slot], &mut context.cluster, counters)
            };
            if !is_flying {
                rays.landed(places[slot], &flight.traveller);
                flights[slot] = None;
                in_flight -= 1;
            }
        }
        if in_flight == 0 && !may_begin {
            return;
        }
    }
}

#[inline(always)]
fn begin<'a>(
    traveller: Traveller,
    start: f32,
    departure: Departure,
    nodes: &'a [WideNode],
    bounds: &Aabb,
) -> Flight<'a> {
    let ray = WideRay::new(&SlabRay::in_world(traveller.origin, traveller.direction, bounds));
    match departure {
        Departure::Scene { node } => Flight::in_scene(traveller, start, nodes, ray, node),
        Departure::Instance { index, .. } => {
            let mut flight = Flight::in_scene(traveller, start, nodes, ray, 0);
            flight.next = Next::FindInstance(index);
            flight
        }
    }
}

/// Enters an instance, or comes back from there: true when the search is then over.
#[inline(always)]
fn enter_instance<'a, const ANY: bool, S: Lanes, C: Count>(
    simd: S,
    scene: &'a Scene,
    (index, inside): (u32, Inside),
    time: f32,
    flight: &mut Flight<'a>,
    context: &mut FlightContext,
    counters: &mut C,
) -> bool {
    counters.instance();
    let id = scene.id(index);
    match scene.in_slot(index) {
        None => false,
        Some(Instance::Geometry(geometry)) => {
            geometry.count(1);
            if let Some(mesh) = geometry.mesh() {
                flight.enter_geometry(id, mesh);
                return false;
            }
            let stack = &mut context.cluster.binary;
            pass_geometry::<ANY, C>(geometry, id, flight.start, &mut flight.traveller, stack, counters)
        }
        Some(Instance::Asset(instance)) if time > 0.0 && instance.is_moving() => {
            pass_moving::<ANY, S, C>(simd, (instance, index), scene, time, flight, context, counters)
        }
        Some(Instance::Asset(instance)) => {
            let prepared = instance.prepared();
            let actor = Actor {
                id,
                asset: instance.asset(),
                prepared,
            };
            flight.enter_inside(actor, prepared.enter_counted(instance.pool()), inside);
            false
        }
    }
}

/// Traverses an instance at a time, which is prepared for this thread alone; true when the search is over.
#[inline(always)]
fn pass_moving<const ANY: bool, S: Lanes, C: Count>(
    simd: S,
    actor: (&AssetInstance, u32),
    scene: &Scene,
    time: f32,
    flight: &mut Flight<'_>,
    context: &mut FlightContext,
    counters: &mut C,
) -> bool {
    let (instance, index) = actor;
    let FlightContext {
        moving,
        cluster,
        moments,
        ..
    } = context;
    let prepared = moments.prepared_at(scene, index, instance, time);
    let actor = Actor {
        id: scene.id(index),
        asset: instance.asset(),
        prepared,
    };
    flight.pass_actor::<ANY, S, C>(
        simd,
        actor,
        prepared.enter_counted(instance.pool()),
        moving,
        cluster,
        counters,
    )
}
