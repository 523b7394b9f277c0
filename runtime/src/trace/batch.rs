use super::{InstanceContext, TraceContext, context::PacketContext, enter_instance, trace, traveller::Traveller};
use crate::{
    Hit, InstanceId, Ray,
    asset_instance::AssetInstance,
    instance::Instance,
    prepared::Whole,
    scene::Scene,
    wide::{self, Bundled, GROUP, PACKET, WideStack},
};
use std::{cell::Cell, ops::Range};

const _: () = assert!(PACKET == u64::BITS as usize);

/// Triangles that a bundle tests, for each of its rays, before these go on alone: it is then not as narrow for the mesh as it
/// seemed from the outside, as where all of a scene's triangles are in one corner.
const TRIANGLES_PER_RAY: usize = 8;

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
/// Guarantee: the answers of [`trace`].
pub(crate) fn trace_together<A: Answer>(
    scene: &Scene,
    rays: &[Ray],
    answers: &mut [A],
    context: &mut TraceContext,
    mut leave: impl FnMut(usize, u64),
) {
    let packets = rays.chunks(PACKET).zip(answers.chunks_mut(PACKET));
    for (first, (rays, answers)) in (0..).step_by(PACKET).zip(packets) {
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
        packet: PacketContext { packet, travellers },
    } = context;
    // What no bundle says otherwise of.
    answers.iter_mut().for_each(|answer| *answer = A::of(None));
    let Some(root) = scene.top_level.nodes().first().filter(|_| !bounds.is_empty()) else {
        return 0;
    };
    packet.load(scene.simd, rays);
    // A bit for each ray that goes alone.
    let left = Cell::new(0u64);
    let leave = |places: Range<usize>| places.for_each(|place| left.set(left.get() | 1 << place));
    packet.part(
        scene.simd,
        root,
        &bounds,
        |bundled| {
            let groups = bundled.groups();
            let places = groups.start * GROUP..(groups.end * GROUP).min(rays.len());
            let Some(wide) = bundled.in_world(scene.top_level.nodes()) else {
                leave(places);
                return;
            };
            travellers[places.clone()].iter_mut().for_each(|known| *known = None);
            let mut bundle = Bundle {
                scene,
                rays,
                travellers: &mut travellers[..],
            };
            wide::walk(
                scene.simd,
                scene.top_level.nodes(),
                0,
                &wide,
                wide.start,
                bundled,
                stack,
                &mut (),
                &mut |index, bundled, _| {
                    bundle.enter_instance::<ANY>(index, bundled, instance);
                    bundled.is_over()
                },
            );
            for place in places {
                if let Some((traveller, _)) = &travellers[place] {
                    answers[place] = A::of(traveller.best);
                }
            }
        },
        leave,
    );
    left.get()
}

/// Rays on their way together.
struct Bundle<'a> {
    scene: &'a Scene,
    rays: &'a [Ray],
    /// Each ray that may hit something, and the scaled `t` at which it begins.
    travellers: &'a mut [Option<(Traveller, f32)>],
}

impl Bundle<'_> {
    fn enter_instance<const ANY: bool>(&mut self, index: u32, bundled: &mut Bundled, context: &mut InstanceContext) {
        if let Some(Instance::Asset(instance)) = self.scene.in_slot(index) {
            let rays = (bundled.groups().len() * GROUP) as u32;
            let whole = instance.prepared().enter(instance.pool(), rays);
            if let Some(whole) = whole.filter(|whole| !whole.nodes.is_empty())
                && self.enter_whole::<ANY>(self.scene.id(index), instance, whole, bundled, &mut context.stack)
            {
                return;
            }
        }
        let Some(bounds) = self.scene.in_slot(index).map(Instance::bounds) else {
            return;
        };
        for group in bundled.groups() {
            for lane in lanes(bundled.meeting(self.scene.simd, group, &bounds)) {
                let place = group * GROUP + lane;
                let Some((traveller, start)) = traveller(self.travellers, self.rays, place) else {
                    continue;
                };
                let before = traveller.limit;
                let is_over = enter_instance::<ANY>(self.scene, index, 0.0, *start, traveller, context, &mut ());
                if is_over {
                    bundled.cut(group, lane, f32::NEG_INFINITY);
                } else if traveller.limit != before
                    && let Some(best) = &traveller.best
                {
                    bundled.cut(group, lane, best.t);
                }
            }
        }
    }

    /// False where the rays must go on one by one.
    fn enter_whole<const ANY: bool>(
        &mut self,
        id: InstanceId,
        instance: &AssetInstance,
        whole: &Whole,
        bundled: &mut Bundled,
        stack: &mut WideStack,
    ) -> bool {
        let Some(wide) = bundled.in_world(&whole.nodes) else {
            return false;
        };
        let simd = self.scene.simd;
        let triangles = instance.asset().model().triangles;
        let mut left = TRIANGLES_PER_RAY * bundled.groups().len() * GROUP;
        wide::walk(
            simd,
            &whole.nodes,
            0,
            &wide,
            wide.start,
            bundled,
            stack,
            &mut (),
            &mut |triangle, bundled, _| {
                if left == 0 {
                    return true;
                }
                left -= 1;
                let corners = triangles[triangle as usize].corners;
                let corners = corners.map(|corner| whole.positions[corner as usize]);
                for group in bundled.groups() {
                    for lane in lanes(bundled.candidates(simd, group, &corners)) {
                        let place = group * GROUP + lane;
                        let Some((traveller, _)) = traveller(self.travellers, self.rays, place) else {
                            continue;
                        };
                        if traveller.test(&corners, id, triangle)
                            && let Some(best) = &traveller.best
                        {
                            bundled.cut(group, lane, if ANY { f32::NEG_INFINITY } else { best.t });
                        }
                    }
                }
                bundled.is_over()
            },
        );
        left > 0
    }
}

/// The ray at a place of the packet, made ready when it first may hit something.
#[inline]
fn traveller<'a>(
    travellers: &'a mut [Option<(Traveller, f32)>],
    rays: &[Ray],
    place: usize,
) -> Option<&'a mut (Traveller, f32)> {
    let known = &mut travellers[place];
    if known.is_none() {
        *known = Traveller::new(&rays[place]);
    }
    known.as_mut()
}

/// The set bits of a mask.
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        lane
    })
}
