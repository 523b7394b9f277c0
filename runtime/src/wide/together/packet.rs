use super::{
    bundled::Bundled,
    group_bundles::GroupBundles,
    ray_bundle::{RayBundle, WideBundle},
    ray_group::{GROUP, RayGroup},
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Ray,
    simd::{Lanes, Portable, SimdLevel},
    wide::WideNode,
};
use std::ops::Range;

/// Rays of a packet.
pub(crate) const PACKET: usize = 64;

pub(super) const GROUPS: usize = PACKET / GROUP;

/// Rays that follow each other in a batch, side by side.
#[derive(Clone, Debug)]
pub(crate) struct Packet {
    pub(super) groups: [RayGroup; GROUPS],
    pub(super) bundles: GroupBundles,
    /// Per group, behind the greatest `t` that matters for any of its rays; −∞ for none at all.
    pub(super) limits: [f32; GROUPS],
}

const _: () = assert!(GROUPS == GROUP);

impl Packet {
    /// Room for a packet. Keep it.
    pub(crate) const fn new() -> Self {
        Self {
            groups: [RayGroup::NONE; GROUPS],
            bundles: GroupBundles::NONE,
            limits: [f32::NEG_INFINITY; GROUPS],
        }
    }

    /// Parts up to [`PACKET`] rays into bundles for a tree with this root and these bounds, in order: `together` takes each
    /// that is coherent, `alone` the places of rays that have to be traced one by one. Rays that it finds to miss all of the
    /// root's children are in neither.
    pub(crate) fn part(
        &mut self,
        level: SimdLevel,
        rays: &[Ray],
        root: &WideNode,
        bounds: &Aabb,
        mut together: impl FnMut(&mut Bundled),
        mut alone: impl FnMut(Range<usize>),
    ) {
        let rays = &rays[..rays.len().min(PACKET)];
        if rays.is_empty() {
            return;
        }
        let bundle = RayBundle::around(level, rays);
        if let Some(bundle) = bundle
            && let Some(wide) = WideBundle::new(&bundle, bounds)
            && !wide.meets_any(level, root, bundle.end)
        {
            return;
        }
        let usable = self.load(level, rays);
        let all = 0..rays.len().div_ceil(GROUP);
        if let (Some(bundle), true) = (bundle, usable == (1 << all.end) - 1) {
            together(&mut Bundled::new(level, self, all, bundle));
            return;
        }
        for (half, rays) in rays.chunks(PACKET / 2).enumerate() {
            let first = half * GROUPS / 2;
            let groups = first..first + rays.len().div_ceil(GROUP);
            let own = (1 << groups.end) - (1 << groups.start);
            match RayBundle::around(level, rays) {
                Some(bundle) if usable & own == own => together(&mut Bundled::new(level, self, groups, bundle)),
                _ => alone(first * GROUP..first * GROUP + rays.len()),
            }
        }
    }

    /// Takes the rays. A bit for each group all of whose rays can hit something.
    fn load(&mut self, level: SimdLevel, rays: &[Ray]) -> u32 {
        #[inline(always)]
        fn body<S: Lanes>(simd: S, packet: &mut Packet, rays: &[Ray]) -> u32 {
            let mut usable = 0;
            for (place, (group, rays)) in packet.groups.iter_mut().zip(rays.chunks(GROUP)).enumerate() {
                usable |= u32::from(group.load(simd, rays)) << place;
            }
            packet.bundles.set(simd, &packet.groups);
            usable
        }
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, packet: &mut Packet, rays: &[Ray]) -> u32 {
                body(simd, packet, rays)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, rays) };
        }
        body(Portable, self, rays)
    }
}
