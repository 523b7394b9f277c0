use super::{
    TraceContext,
    context::{FlightContext, PacketContext, WholeRoom},
    fly::{Departure, IN_FLIGHT, Rays, fly},
    trace,
    traveller::Traveller,
    whole_tree::WholeTree,
};
use crate::{
    Hit, InstanceId, Ray,
    instance::Instance,
    prepared::Whole,
    scene::Scene,
    set_bits::set_bits,
    simd::prefetch,
    wide::{Bundled, GROUP, GroupHits, PACKET, Part, walk_together},
};
use restpose_formats::rows::TriangleRow;
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
        flight,
        packet:
            PacketContext {
                packet,
                best,
                travellers,
                hits,
                stack,
                whole: whole_room,
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
                stack,
                &mut |part, bundled| {
                    match part {
                        Part::Leaf { leaf, groups } => {
                            bundle.enter_instance::<ANY>(leaf, groups, bundled, whole_room, flight);
                        }
                        Part::Alone { node, places } => {
                            bundle.alone_from::<ANY>(Departure::Scene { node }, places, bundled, flight);
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
    /// Rays that have gone alone, as they begin, and the scaled `t` at which they begin; meaningful where `ready` has a bit.
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
        room: &mut WholeRoom,
        context: &mut FlightContext,
    ) {
        let scene = self.scene;
        let Some(instance) = scene.in_slot(index) else {
            return;
        };
        if let Instance::Asset(instance) = instance {
            let prepared = instance.prepared();
            let whole = prepared.enter(instance.pool()).filter(|whole| !whole.nodes.is_empty());
            let triangles = instance.asset().model().triangles;
            if let Some(whole) = whole
                && self.enter_whole::<ANY>((scene.id(index), whole, triangles), bundled, room)
            {
                prepared.count_whole(groups.count_ones() * GROUP as u32);
                return;
            }
        }
        let places = bundled.meeting(scene.simd, groups, &instance.bounds());
        self.alone_from::<ANY>(Departure::Instance { index }, places, bundled, context);
    }

    /// Traces rays that part on the way to instances.
    fn alone_from<const ANY: bool>(
        &mut self,
        departure: Departure,
        places: u64,
        bundled: &mut Bundled,
        context: &mut FlightContext,
    ) {
        let scene = self.scene;
        self.alone(places, bundled, |rays: &mut Alone<ANY>| {
            fly::<ANY, IN_FLIGHT, _, _>(scene, departure, 0.0, rays, context, &mut ());
        });
    }

    /// Traces rays that part.
    fn alone<const ANY: bool>(
        &mut self,
        places: u64,
        bundled: &mut Bundled,
        trace: impl FnOnce(&mut Alone<'_, '_, ANY>),
    ) {
        for place in set_bits(places & !self.ready) {
            self.travellers[place] = Traveller::new(&self.rays[place]);
        }
        self.ready |= places;
        let mut alone = Alone::<ANY> {
            places,
            travellers: self.travellers,
            best: self.best,
            bundled,
            cut: 0,
        };
        trace(&mut alone);
        let cut = alone.cut;
        if cut != 0 {
            bundled.shorten(self.scene.simd, cut);
        }
    }

    /// False where the rays must go one by one. The whole is an instance's, and its tree is not empty.
    fn enter_whole<const ANY: bool>(
        &mut self,
        (id, whole, triangles): (InstanceId, &Whole, &[TriangleRow]),
        bundled: &mut Bundled,
        room: &mut WholeRoom,
    ) -> bool {
        let Some(together) = bundled.in_world(&whole.nodes) else {
            return false;
        };
        let level = self.scene.simd;
        let WholeRoom {
            stack,
            lone_stack,
            rays,
        } = room;
        let mut tree = WholeTree::new(id, whole, triangles, rays);
        walk_together(level, &whole.nodes, &together, bundled, stack, &mut |part, bundled| {
            match part {
                Part::Leaf { leaf, groups } => self.test::<ANY>(id, leaf, &tree.corners(leaf), groups, bundled),
                Part::Alone { node, places } => self.alone(places, bundled, |rays: &mut Alone<ANY>| {
                    while let Some((place, mut traveller, start)) = rays.next() {
                        tree.pass::<ANY>(level, node, (place, &mut traveller, start), lone_stack);
                        rays.landed(place, &traveller);
                    }
                }),
            }
            bundled.is_over()
        });
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

/// Rays that part from a bundle.
struct Alone<'a, 'b, const ANY: bool> {
    /// Those that are still to come.
    places: u64,
    travellers: &'a [Option<(Traveller, f32)>],
    best: &'a mut [Option<Hit>; PACKET],
    bundled: &'a mut Bundled<'b>,
    /// Groups of those that found a better hit.
    cut: u32,
}

impl<const ANY: bool> Rays for Alone<'_, '_, ANY> {
    fn next(&mut self) -> Option<(usize, Traveller, f32)> {
        loop {
            let place = set_bits(self.places).next()?;
            self.places &= self.places - 1;
            let best = self.best[place];
            if ANY && best.is_some() {
                continue;
            }
            let Some((traveller, start)) = &self.travellers[place] else {
                continue;
            };
            let mut traveller = traveller.clone();
            if let Some(best) = best {
                traveller.resume(best);
            }
            return Some((place, traveller, *start));
        }
    }

    fn landed(&mut self, place: usize, traveller: &Traveller) {
        if let Some(best) = traveller.best
            && self.best[place] != Some(best)
        {
            self.best[place] = Some(best);
            self.bundled.cut(place, if ANY { f32::NEG_INFINITY } else { best.t });
            self.cut |= 1 << (place / GROUP);
        }
    }
}
