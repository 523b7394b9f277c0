use super::{
    Answer, TraceContext,
    fly::{Departure, IN_FLIGHT, Rays, fly},
    ray_order::place,
    traveller::Traveller,
};
use crate::{Hit, Ray, scene::Scene, simd::prefetch};

/// Sorted rays are far from each other in memory: so many before its turn each is asked for.
const RAYS_AHEAD: usize = 8;

/// Traces rays that go alone, in the order of their keys ([`RayOrder`](super::RayOrder)): as many of the first ones as there
/// is room for hits, all `None` before.
pub(crate) fn trace_sorted<A: Answer>(
    scene: &Scene,
    rays: &[Ray],
    keys: &[u64],
    hits: &mut [Option<Hit>],
    context: &mut TraceContext,
) {
    if scene.top_level.bounds().is_empty() {
        return;
    }
    let mut sorted = Sorted {
        rays,
        keys,
        hits,
        next: 0,
    };
    let context = &mut context.flight;
    let departure = Departure::Scene { node: 0 };
    if A::ANY {
        fly::<true, IN_FLIGHT, _, _>(scene, departure, 0.0, &mut sorted, context, &mut ());
    } else {
        fly::<false, IN_FLIGHT, _, _>(scene, departure, 0.0, &mut sorted, context, &mut ());
    }
}

/// Rays of a batch, by their keys.
struct Sorted<'a> {
    rays: &'a [Ray],
    /// Of these rays, and of those that come after them.
    keys: &'a [u64],
    /// None of any, so far.
    hits: &'a mut [Option<Hit>],
    next: usize,
}

impl Rays for Sorted<'_> {
    fn next(&mut self) -> Option<(usize, Traveller, f32)> {
        while self.next < self.hits.len() {
            let at = self.next;
            self.next += 1;
            if let Some(later) = self.keys.get(at + RAYS_AHEAD) {
                prefetch(std::slice::from_ref(&self.rays[place(*later)]));
            }
            if let Some((traveller, start)) = Traveller::new(&self.rays[place(self.keys[at])]) {
                return Some((at, traveller, start));
            }
        }
        None
    }

    fn landed(&mut self, place: usize, traveller: &Traveller) {
        self.hits[place] = traveller.best;
    }
}
