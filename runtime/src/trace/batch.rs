use super::{TraceContext, bundle::Bundle, context::PacketContext, fly::Departure, trace};
use crate::{
    Hit, Ray,
    scene::Scene,
    set_bits::set_bits,
    simd::prefetch,
    wide::{PACKET, Part, walk_together},
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

/// Traces those of rays that follow each other that are coherent, together: through the tree over instances, those of whole
/// instances, and those of clusters. `leave` is told of the others: the place of the first of up to 64,
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
                inside,
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
            let nodes = scene.top_level.nodes();
            let together = bundled.is_narrow(&bounds, nodes.len()).then(|| bundled.in_world(nodes));
            let Some(together) = together.flatten() else {
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
                &mut &nodes[..],
                &together,
                bundled,
                stack,
                &mut |part, bundled| {
                    match part {
                        Part::Leaf { leaf, groups } => {
                            bundle.enter_instance::<ANY>(leaf, groups, bundled, inside, flight);
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
