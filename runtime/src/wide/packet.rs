use super::{
    WideNode,
    bundle::{RayBundle, WideBundle},
    ray_group::{GROUP, RayGroup},
    walk::Limited,
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Ray,
    simd::{Lanes, Portable, SimdLevel},
};
use std::ops::Range;

/// Rays of a packet.
pub(crate) const PACKET: usize = 64;

const GROUPS: usize = PACKET / GROUP;

/// Groups that go through a tree together. Measured on HORSE and ELEPHANT, 1M rays of a camera: of one, two, four and
/// eight, four are the fastest or within a tenth of it.
const TOGETHER: usize = 4;

/// Rays that follow each other in a batch, side by side.
///
/// What it says of them leaves out no hit; hits themselves are what
/// [`PreparedRay::intersect`](crate::triangle::PreparedRay::intersect) makes of them.
#[derive(Clone, Debug)]
pub(crate) struct Packet {
    groups: [RayGroup; GROUPS],
    count: usize,
}

impl Packet {
    /// Room for a packet. Keep it.
    pub(crate) const fn new() -> Self {
        Self {
            groups: [RayGroup::NONE; GROUPS],
            count: 0,
        }
    }

    /// Takes up to [`PACKET`] rays.
    pub(crate) fn load(&mut self, level: SimdLevel, rays: &[Ray]) {
        #[inline(always)]
        fn body<S: Lanes>(simd: S, packet: &mut Packet, rays: &[Ray]) {
            packet.count = rays.len().min(PACKET);
            for (group, rays) in packet.groups.iter_mut().zip(rays.chunks(GROUP)) {
                group.load(simd, rays);
            }
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, packet: &mut Packet, rays: &[Ray]) {
                body(simd, packet, rays);
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, rays) };
        }
        body(Portable, self, rays);
    }

    /// Parts the packet into bundles for a tree with this root and these bounds, in order: `together` takes each that is
    /// coherent, `alone` the places of rays that have to be traced one by one. Rays that it finds to miss all of the
    /// root's children are in neither.
    pub(crate) fn part(
        &mut self,
        level: SimdLevel,
        root: &WideNode,
        bounds: &Aabb,
        mut together: impl FnMut(&mut Bundled),
        mut alone: impl FnMut(Range<usize>),
    ) {
        let all = 0..self.count.div_ceil(GROUP);
        let bundle = RayBundle::around(level, &self.groups[all.clone()]);
        if let Some(wide) = bundle.and_then(|bundle| WideBundle::new(&bundle, bounds))
            && !wide.meets_any(level, root, self.limit(&all))
        {
            return;
        }
        for first in all.clone().step_by(TOGETHER) {
            let groups = first..(first + TOGETHER).min(all.end);
            match RayBundle::around(level, &self.groups[groups.clone()]) {
                Some(bundle) => together(&mut Bundled {
                    limit: self.limit(&groups),
                    packet: self,
                    groups,
                    bundle,
                }),
                None => alone(groups.start * GROUP..(groups.end * GROUP).min(self.count)),
            }
        }
    }

    /// Behind the greatest `t` that matters for any ray of some groups.
    #[inline]
    fn limit(&self, groups: &Range<usize>) -> f32 {
        let greater = |a: f32, b: f32| if a > b { a } else { b };
        let limits = self.groups[groups.clone()].iter().map(|group| *group.limits());
        // Lane by lane, so that no comparison waits for the one before it.
        let eight = limits.fold([f32::NEG_INFINITY; GROUP], |a, b| {
            std::array::from_fn(|k| greater(a[k], b[k]))
        });
        let four: [f32; 4] = std::array::from_fn(|k| greater(eight[k], eight[k + 4]));
        let greatest = greater(greater(four[0], four[2]), greater(four[1], four[3]));
        if greatest == f32::NEG_INFINITY {
            greatest
        } else {
            greatest.next_up()
        }
    }
}

/// Nodes that a bundle meets, for each of its rays, at which the rays are faster alone.
const NODES_PER_RAY: f32 = 2.0;

/// Rays of a packet that go through trees in world space together, as the traveller of [`walk`](super::walk).
#[derive(Debug)]
pub(crate) struct Bundled<'a> {
    packet: &'a mut Packet,
    groups: Range<usize>,
    bundle: RayBundle,
    limit: f32,
}

impl Limited for Bundled<'_> {
    #[inline]
    fn limit(&self) -> f32 {
        self.limit
    }
}

impl Bundled<'_> {
    /// Its groups: the rays of group g have the places from `g * GROUP` on in their packet.
    #[inline]
    pub(crate) fn groups(&self) -> Range<usize> {
        self.groups.clone()
    }

    /// Ready for a tree; `None` where the rays are to go one by one: they are too far apart, or distances overflow.
    #[inline]
    pub(crate) fn in_world(&self, tree: &[WideNode]) -> Option<WideBundle> {
        let bounds = tree.first()?.around();
        let met = self.bundle.breadth(&bounds, self.limit) * tree.len() as f32;
        let is_narrow = met <= NODES_PER_RAY * (self.groups.len() * GROUP) as f32;
        is_narrow.then(|| WideBundle::new(&self.bundle, &bounds)).flatten()
    }

    /// A bit for each ray of a group that may hit the triangle: each ray that does is among them, even where it lies
    /// outside of its range.
    #[inline]
    pub(crate) fn candidates(&mut self, level: SimdLevel, group: usize, corners: &[[f32; 3]; 3]) -> u32 {
        self.packet.groups[group].candidates(level, corners)
    }

    /// A bit for each ray of a group that may hit something inside `bounds` before its end.
    #[inline]
    pub(crate) fn meeting(&self, level: SimdLevel, group: usize, bounds: &Aabb) -> u32 {
        self.packet.groups[group].meeting(level, bounds, self.bundle.outwards(bounds))
    }

    /// Says that beyond `t` no hit of a ray matters any more; −∞ for none at all.
    #[inline]
    pub(crate) fn cut(&mut self, group: usize, lane: usize, t: f32) {
        self.packet.groups[group].cut(lane, t);
        self.limit = self.packet.limit(&self.groups);
    }

    /// True when none of its rays looks for anything any more.
    #[inline]
    pub(crate) fn is_over(&self) -> bool {
        self.limit == f32::NEG_INFINITY
    }
}
