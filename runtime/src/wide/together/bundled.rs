use super::{
    group_bundles::{GroupBundles, WideGroups},
    packet::{GROUPS, Packet},
    ray_bundle::{RayBundle, WideBundle},
    ray_group::{GROUP, GroupHits, RayGroup},
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb,
    cluster_frame::{BundleFrame, LocalFrame, SlabLanes},
    set_bits::set_bits,
    simd::{Lanes, Portable, SimdLevel},
    wide::WideNode,
};
use std::ops::Range;

/// Rays of a packet in a cluster's local space. Keep it.
#[derive(Clone, Debug)]
pub(crate) struct LocalRays {
    rays: [SlabLanes; GROUPS],
    bundles: GroupBundles,
}

impl LocalRays {
    pub(crate) const NONE: Self = Self {
        rays: [SlabLanes::NONE; GROUPS],
        bundles: GroupBundles::NONE,
    };
}

/// Nodes that a bundle is expected to meet, for each of its rays, at which the rays are faster alone. Bundles part by
/// themselves, which costs those that have to. With 8, pictures of 40,000 and 100,000 rays of 147k triangles took 1.5 times as long; 32 to
/// 512 differ by less than the noise, but with 4,096 and more rays of one octant from anywhere took twice the time or more.
const NODES_PER_RAY: f32 = 64.0;

/// The part of a tree's cross-section that a bundle covers at which its rays are faster alone: the tree may be small. Without it rays of
/// one octant from anywhere took ten times as long through 576 triangles; with 0.3 a picture of 4,000 rays of these took three times as
/// long as with this.
const MOST_BREADTH: f32 = 0.7;

/// Rays of a packet that go through trees together.
#[derive(Debug)]
pub(crate) struct Bundled<'a> {
    pub(super) packet: &'a mut Packet,
    /// A bit for each group.
    pub(super) groups: u32,
    bundle: RayBundle,
    pub(super) limit: f32,
}

/// A bundle ready for a tree.
#[derive(Debug)]
pub(crate) struct Together<'a> {
    pub(super) all: WideBundle,
    pub(super) groups: WideGroups,
    /// Those that go, as bits.
    pub(super) going: u32,
    /// By how much planes move, per axis.
    pub(super) outwards: [f32; 3],
    /// The rays in the tree's own space, where it is not in world space.
    pub(super) rays: Option<&'a [SlabLanes; GROUPS]>,
}

impl<'a> Bundled<'a> {
    pub(super) fn new(level: SimdLevel, packet: &'a mut Packet, groups: Range<usize>, bundle: RayBundle) -> Self {
        packet.limits = [f32::NEG_INFINITY; GROUPS];
        let mut out = Self {
            packet,
            groups: (1 << groups.end) - (1 << groups.start),
            bundle,
            limit: f32::NEG_INFINITY,
        };
        out.shorten(level, out.groups);
        out
    }

    /// The places of its rays in their packet, as bits.
    #[inline]
    pub(crate) fn places(&self) -> u64 {
        set_bits(self.groups.into()).fold(0, |places, group| {
            places | u64::from(self.packet.groups[group].used) << (group * GROUP)
        })
    }

    /// Ready for a tree; `None` where the rays are to go one by one: where distances overflow.
    #[inline]
    pub(crate) fn in_world(&self, tree: &[WideNode]) -> Option<Together<'static>> {
        // A place in it is one number (`walk`).
        if tree.len() > 1 << 29 {
            return None;
        }
        let bounds = &tree.first()?.around();
        let all = WideBundle::new(&self.bundle, bounds)?;
        let outwards = self.bundle.outwards(bounds);
        Some(Together {
            groups: WideGroups::new(&self.packet.bundles, outwards, all.near_row),
            all,
            going: self.groups,
            outwards,
            rays: None,
        })
    }

    /// Whether the rays are expected to meet so little of a tree that going together pays.
    #[inline]
    pub(crate) fn is_narrow(&self, bounds: &Aabb, nodes: usize) -> bool {
        let breadth = self.bundle.breadth(bounds, self.limit);
        let rays = self.groups.count_ones() * GROUP as u32;
        // A NaN meets all.
        breadth <= MOST_BREADTH && breadth * nodes as f32 <= NODES_PER_RAY * rays as f32
    }

    /// Some groups, ready for a cluster's tree in its local space, which `rays` then hold them in; and what its boxes need.
    /// `None` where the rays are to go one by one: where numbers could under- or overflow.
    pub(crate) fn in_cluster<'r>(
        &self,
        level: SimdLevel,
        groups: u32,
        (local, bounds_world): (&LocalFrame, &Aabb),
        rays: &'r mut LocalRays,
    ) -> Option<(Together<'r>, BundleFrame)> {
        let frame = local.bundle(self.bundle.longest, self.bundle.distance(bounds_world))?;
        let LocalRays { rays, bundles } = rays;
        if !self.to_local(level, groups, (local, &frame), rays, bundles) {
            return None;
        }
        let (all, outwards) = bundles.join(groups)?;
        let together = Together {
            groups: WideGroups::new(bundles, outwards, all.near_row),
            all,
            going: groups,
            outwards,
            rays: Some(rays),
        };
        Some((together, frame))
    }

    /// Whether all origins are numbers there.
    fn to_local(
        &self,
        level: SimdLevel,
        groups: u32,
        frame: (&LocalFrame, &BundleFrame),
        rays: &mut [SlabLanes; GROUPS],
        bundles: &mut GroupBundles,
    ) -> bool {
        #[inline(always)]
        fn body<S: Lanes>(
            simd: S,
            packet: &Packet,
            groups: u32,
            (local, bundle): (&LocalFrame, &BundleFrame),
            rays: &mut [SlabLanes; GROUPS],
            bundles: &mut GroupBundles,
        ) -> bool {
            let mut left = groups;
            let mut finite = 0xff;
            while left != 0 {
                let group = left.trailing_zeros() as usize % GROUPS;
                left &= left - 1;
                let RayGroup { slabs, direction, .. } = &packet.groups[group];
                local.enter_lanes(simd, &slabs.origin, direction, bundle, &mut rays[group]);
                for origin in &rays[group].origin {
                    // Extremes would not tell of what is no number.
                    finite &= simd.lt8(simd.abs8(simd.load8(origin)), simd.splat8(f32::INFINITY));
                }
            }
            let [a, b, c, d, e, f, g, h] = &*rays;
            bundles.set_slabs(simd, [a, b, c, d, e, f, g, h]);
            bundles.start = packet.bundles.start;
            finite == 0xff
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(
                simd: Avx2,
                packet: &Packet,
                groups: u32,
                frame: (&LocalFrame, &BundleFrame),
                rays: &mut [SlabLanes; GROUPS],
                bundles: &mut GroupBundles,
            ) -> bool {
                body(simd, packet, groups, frame, rays, bundles)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self.packet, groups, frame, rays, bundles) };
        }
        body(Portable, self.packet, groups, frame, rays, bundles)
    }

    /// A bit for each ray of these groups that hits the triangle where it matters, and what
    /// [`PreparedRay::intersect`](crate::triangle::PreparedRay::intersect) says of it, by group.
    pub(crate) fn hits(
        &self,
        level: SimdLevel,
        groups: u32,
        corners: &[[f32; 3]; 3],
        hits: &mut [GroupHits; GROUPS],
    ) -> u64 {
        #[inline(always)]
        fn body<S: Lanes>(
            simd: S,
            packet: &Packet,
            mut groups: u32,
            corners: &[[f32; 3]; 3],
            hits: &mut [GroupHits; GROUPS],
        ) -> u64 {
            let mut found = 0;
            while groups != 0 {
                let group = groups.trailing_zeros() as usize % GROUPS;
                groups &= groups - 1;
                found |= u64::from(packet.groups[group].hits(simd, corners, &mut hits[group])) << (group * GROUP);
            }
            found
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(
                simd: Avx2,
                packet: &Packet,
                groups: u32,
                corners: &[[f32; 3]; 3],
                hits: &mut [GroupHits; GROUPS],
            ) -> u64 {
                body(simd, packet, groups, corners, hits)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self.packet, groups, corners, hits) };
        }
        body(Portable, self.packet, groups, corners, hits)
    }

    /// The places of rays of these groups that may hit something inside `bounds` before their end, as bits.
    pub(crate) fn meeting(&self, level: SimdLevel, groups: u32, bounds: &Aabb) -> u64 {
        let outwards = self.bundle.outwards(bounds);
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, bundled: &Bundled, groups: u32, bounds: &Aabb, outwards: [f32; 3]) -> u64 {
                bundled.meeting_with(simd, groups, None, bounds, outwards)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, groups, bounds, outwards) };
        }
        self.meeting_with(Portable, groups, None, bounds, outwards)
    }

    /// [`Self::meeting`], in the local space of a cluster that they have [entered](Self::in_cluster); the box has been widened by the
    /// margin, and none of its sides is NaN.
    pub(crate) fn meeting_in(&self, level: SimdLevel, together: &Together, groups: u32, bounds: &Aabb) -> u64 {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, bundled: &Bundled, together: &Together, groups: u32, bounds: &Aabb) -> u64 {
                bundled.meeting_with(simd, groups, together.rays, bounds, together.outwards)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, together, groups, bounds) };
        }
        self.meeting_with(Portable, groups, together.rays, bounds, together.outwards)
    }

    /// [`Self::meeting`] in the space that `rays` are in, world space without any, where `outwards` is by how much planes move, per
    /// axis.
    #[inline(always)]
    pub(super) fn meeting_with<S: Lanes>(
        &self,
        simd: S,
        mut groups: u32,
        rays: Option<&[SlabLanes; GROUPS]>,
        bounds: &Aabb,
        outwards: [f32; 3],
    ) -> u64 {
        let mut places = 0;
        while groups != 0 {
            let group = groups.trailing_zeros() as usize % GROUPS;
            groups &= groups - 1;
            let own = &self.packet.groups[group];
            let slabs = match rays {
                Some(rays) => &rays[group],
                None => &own.slabs,
            };
            places |= u64::from(own.meeting(simd, slabs, bounds, outwards)) << (group * GROUP);
        }
        places
    }

    /// Says that beyond `t` no hit of the ray at a place matters any more; −∞ for none at all. Counts when its group is
    /// [shortened](Self::shorten).
    #[inline]
    pub(crate) fn cut(&mut self, place: usize, t: f32) {
        self.packet.groups[place / GROUP].cut(place % GROUP, t);
    }

    /// Makes what was cut in these groups count.
    pub(crate) fn shorten(&mut self, level: SimdLevel, groups: u32) {
        #[inline(always)]
        fn greatest<S: Lanes>(simd: S, eight: &[f32; 8]) -> f32 {
            let [a, b] = simd.halves(simd.load8(eight));
            let four = simd.max4(a, b);
            let two = simd.max4(four, simd.rotate4(simd.rotate4(four)));
            simd.store4(simd.max4(two, simd.rotate4(two)))[0]
        }
        #[inline(always)]
        fn body<S: Lanes>(simd: S, packet: &mut Packet, mut groups: u32) -> f32 {
            while groups != 0 {
                let group = groups.trailing_zeros() as usize % GROUPS;
                groups &= groups - 1;
                let limit = greatest(simd, packet.groups[group].limits());
                let ended = limit == f32::NEG_INFINITY;
                packet.limits[group] = if ended { limit } else { limit.next_up() };
            }
            greatest(simd, &packet.limits)
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, packet: &mut Packet, groups: u32) -> f32 {
                body(simd, packet, groups)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            unsafe {
                self.limit = compiled(simd, self.packet, groups);
            }
            return;
        }
        self.limit = body(Portable, self.packet, groups);
    }

    /// True when none of its rays looks for anything any more.
    #[inline]
    pub(crate) fn is_over(&self) -> bool {
        self.limit == f32::NEG_INFINITY
    }
}
