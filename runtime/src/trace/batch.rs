use super::{InstanceContext, TraceContext, context::PacketContext, enter_instance, trace, traveller::Traveller};
use crate::{
    Hit, InstanceId, Ray,
    asset_instance::AssetInstance,
    cluster_frame::SlabRay,
    instance::Instance,
    prepared::Whole,
    scene::Scene,
    set_bits::set_bits,
    simd::prefetch,
    wide::{self, Bundled, GROUP, GroupHits, PACKET, Part, WideRay, walk_together},
};
use std::cell::Cell;

const _: () = assert!(PACKET == u64::BITS as usize);

/// What is asked of a ray.
pub(crate) trait Answer: Send + Sized {
    /// Any hit will do.
    const ANY: bool;
    fn of(hit: Option<Hit>) -> Self;

    /// The hit of a ray that goes alone; see [`trace`].
    fn find(scene: &Scene, ray: &Ray, time: f32, context: &mut TraceContext) -> Option<Hit> {
        if Self::ANY {
            trace::<true>(scene, ray, time, context, &mut ())
        } else {
            trace::<false>(scene, ray, time, context, &mut ())
        }
    }
}

impl Answer for Option<Hit> {
    const ANY: bool = false;
    fn of(hit: Option<Hit>) -> Self {
        hit
    }
}

impl Answer for bool {
    const ANY: bool = true;
    fn of(hit: Option<Hit>) -> Self {
        hit.is_some()
    }
}

/// Traces those of rays that follow each other that are coherent, together wherever all triangles have been posed: through
/// the tree over instances and those of whole instances. `leave` is told of the others: the place of the first of up to 64,
/// and a bit for each that must go alone.
///
/// `rays` may go on behind those that are asked for: the next to be.
///
/// Guarantee: the answers of [`trace`].
pub(crate) fn trace_together<A: Answer>(
    scene: &Scene,
    rays: &[Ray],
    answers: &mut [A],
    context: &mut TraceContext,
    mut leave: impl FnMut(usize, u64),
) {
    let mut later = rays;
    for (first, answers) in (0..).step_by(PACKET).zip(answers.chunks_mut(PACKET)) {
        let rays;
        (rays, later) = later.split_at(answers.len());
        // Between packets the machine forgets that rays follow each other.
        prefetch(&later[..later.len().min(PACKET)]);
        let alone = if A::ANY {
            trace_packet::<true, A>(scene, rays, answers, context)
        } else {
            trace_packet::<false, A>(scene, rays, answers, context)
        };
        leave(first, alone);
    }
}

/// Which rays must go alone.
fn trace_packet<const ANY: bool, A: Answer>(
    scene: &Scene,
    rays: &[Ray],
    answers: &mut [A],
    context: &mut TraceContext,
) -> u64 {
    let bounds = scene.top_level.bounds();
    let TraceContext {
        stack,
        instance,
        packet:
            PacketContext {
                packet,
                best,
                travellers,
                hits,
                stack: packet_stack,
            },
    } = context;
    // What no bundle says otherwise of.
    answers.iter_mut().for_each(|answer| *answer = A::of(None));
    let Some(root) = scene.top_level.nodes().first().filter(|_| !bounds.is_empty()) else {
        return 0;
    };
    // A bit for each ray that goes alone.
    let left = Cell::new(0u64);
    packet.part(
        scene.simd,
        rays,
        root,
        &bounds,
        |bundled| {
            let places = bundled.places();
            let Some(together) = bundled.in_world(scene.top_level.nodes()) else {
                left.set(left.get() | places);
                return;
            };
            best.fill(None);
            let mut bundle = Bundle {
                scene,
                rays,
                best,
                travellers: &mut travellers[..],
                ready: 0,
                hits,
            };
            walk_together(
                scene.simd,
                scene.top_level.nodes(),
                &together,
                bundled,
                packet_stack,
                &mut |part, bundled| {
                    match part {
                        Part::Leaf { leaf, groups } => bundle.enter_instance::<ANY>(leaf, groups, bundled, instance),
                        Part::Alone { node, places } => {
                            bundle.alone::<ANY>(places, bundled, |traveller, start| {
                                let slab = SlabRay::in_world(traveller.origin, traveller.direction, &bounds);
                                wide::walk(
                                    scene.simd,
                                    scene.top_level.nodes(),
                                    node,
                                    &WideRay::new(&slab),
                                    start,
                                    traveller,
                                    stack,
                                    &mut (),
                                    &mut |index, traveller, counters| {
                                        enter_instance::<ANY>(scene, index, 0.0, start, traveller, instance, counters)
                                    },
                                );
                            });
                        }
                    }
                    bundled.is_over()
                },
            );
            for place in set_bits(places) {
                if bundle.best[place].is_some() {
                    answers[place] = A::of(bundle.best[place]);
                }
            }
        },
        |places| places.for_each(|place| left.set(left.get() | 1 << place)),
    );
    left.get()
}

/// Rays on their way together.
struct Bundle<'a> {
    scene: &'a Scene,
    rays: &'a [Ray],
    /// Per ray, the best hit so far.
    best: &'a mut [Option<Hit>; PACKET],
    /// Rays that went alone, and the scaled `t` at which they begin; meaningful where `ready` has a bit.
    travellers: &'a mut [Option<(Traveller, f32)>],
    ready: u64,
    hits: &'a mut [GroupHits; PACKET / GROUP],
}

impl Bundle<'_> {
    fn enter_instance<const ANY: bool>(
        &mut self,
        index: u32,
        groups: u32,
        bundled: &mut Bundled,
        context: &mut InstanceContext,
    ) {
        let scene = self.scene;
        if let Some(Instance::Asset(instance)) = scene.in_slot(index) {
            let prepared = instance.prepared();
            let whole = prepared.enter(instance.pool()).filter(|whole| !whole.nodes.is_empty());
            if let Some(whole) = whole
                && self.enter_whole::<ANY>(scene.id(index), instance, whole, bundled, context)
            {
                prepared.count_whole(groups.count_ones() * GROUP as u32);
                return;
            }
        }
        let Some(bounds) = scene.in_slot(index).map(Instance::bounds) else {
            return;
        };
        let places = bundled.meeting(scene.simd, groups, &bounds);
        self.alone::<ANY>(places, bundled, |traveller, start| {
            enter_instance::<ANY>(scene, index, 0.0, start, traveller, context, &mut ());
        });
    }

    /// Traces rays one by one.
    fn alone<const ANY: bool>(
        &mut self,
        places: u64,
        bundled: &mut Bundled,
        mut trace: impl FnMut(&mut Traveller, f32),
    ) {
        let mut cut = 0;
        for place in set_bits(places) {
            if self.ready >> place & 1 == 0 {
                self.travellers[place] = Traveller::new(&self.rays[place]);
                self.ready |= 1 << place;
            }
            let Some((traveller, start)) = &mut self.travellers[place] else {
                continue;
            };
            if let Some(best) = self.best[place] {
                if ANY {
                    continue;
                }
                traveller.resume(best);
            }
            trace(traveller, *start);
            if let Some(best) = traveller.best
                && self.best[place] != Some(best)
            {
                self.best[place] = Some(best);
                bundled.cut(place, if ANY { f32::NEG_INFINITY } else { best.t });
                cut |= 1 << (place / GROUP);
            }
        }
        if cut != 0 {
            bundled.shorten(self.scene.simd, cut);
        }
    }

    /// False where the rays must go one by one.
    fn enter_whole<const ANY: bool>(
        &mut self,
        id: InstanceId,
        instance: &AssetInstance,
        whole: &Whole,
        bundled: &mut Bundled,
        context: &mut InstanceContext,
    ) -> bool {
        let bounds = whole.nodes[0].around();
        let Some(together) = bundled.in_world(&whole.nodes) else {
            return false;
        };
        let InstanceContext {
            stack, packet_stack, ..
        } = context;
        let simd = self.scene.simd;
        let triangles = instance.asset().model().triangles;
        let corners = |triangle: u32| {
            let corners = triangles[triangle as usize].corners;
            corners.map(|corner| whole.positions[corner as usize])
        };
        walk_together(
            simd,
            &whole.nodes,
            &together,
            bundled,
            packet_stack,
            &mut |part, bundled| {
                match part {
                    Part::Leaf { leaf, groups } => self.test::<ANY>(id, leaf, &corners(leaf), groups, bundled),
                    Part::Alone { node, places } => self.alone::<ANY>(places, bundled, |traveller, start| {
                        let slab = SlabRay::in_world(traveller.origin, traveller.direction, &bounds);
                        wide::walk(
                            simd,
                            &whole.nodes,
                            node,
                            &WideRay::new(&slab),
                            start,
                            traveller,
                            stack,
                            &mut (),
                            &mut |triangle, traveller, _| traveller.test(&corners(triangle), id, triangle) && ANY,
                        );
                    }),
                }
                bundled.is_over()
            },
        );
        true
    }

    /// Tests a triangle against some groups.
    fn test<const ANY: bool>(
        &mut self,
        instance: InstanceId,
        triangle: u32,
        corners: &[[f32; 3]; 3],
        groups: u32,
        bundled: &mut Bundled,
    ) {
        let found = bundled.hits(self.scene.simd, groups, corners, self.hits);
        let mut cut = 0;
        for place in set_bits(found) {
            let (hits, lane) = (&self.hits[place / GROUP], place % GROUP);
            let hit = Hit {
                t: hits.t[lane],
                u: hits.u[lane],
                v: hits.v[lane],
                instance,
                triangle,
            };
            if self.best[place].is_none_or(|best| hit.is_before(&best)) {
                self.best[place] = Some(hit);
                bundled.cut(place, if ANY { f32::NEG_INFINITY } else { hit.t });
                cut |= 1 << (place / GROUP);
            }
        }
        if cut != 0 {
            bundled.shorten(self.scene.simd, cut);
        }
    }
}
