//! All builders that are measured, a line each: a new one joins all tables by joining the list.

use super::{
    tree::TreeKind,
    worker::{Worker, bvh_worker, kd_worker, refit_worker},
};
use crate::MeasureError;
use restpose_builders::{
    bvh::{BinnedBvh, BvhBuilder, FusedBvh, GridBvh, HybridBvh, MedianBvh, SweepBvh},
    kd::StreamedKd,
};
use restpose_runtime::{
    build::{BinCount, KdBuilder, StreamedBvh},
    simd::SimdLevel,
};

/// A builder.
pub(super) struct Builder {
    /// As on the command line.
    pub name: &'static str,
    pub kind: TreeKind,
    /// Where it is described.
    pub source: &'static str,
    pub threads: Threads,
    /// Somebody else's.
    pub is_peer: bool,
    /// A worker for so many threads, with nothing built yet.
    pub make: fn(usize) -> Result<Box<dyn Worker>, MeasureError>,
}

/// The threads that a builder makes use of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Threads {
    One,
    /// Those of the pool that it runs in, or as many as it is made for.
    Any,
    /// All of the machine, whatever it is told.
    #[cfg(feature = "peers")]
    All,
}

use Threads::{Any, One};
use TreeKind::{Bvh, Kd};

/// All builders. The first of each kind is the one that the others are compared with.
pub(super) fn builders() -> Vec<Builder> {
    let own = |kind, name, source, threads, make| Builder {
        name,
        kind,
        source,
        threads,
        is_peer: false,
        make,
    };
    #[cfg_attr(
        not(feature = "peers"),
        expect(unused_mut, reason = "nothing is added without peers")
    )]
    let mut all = vec![
        own(Bvh, "bvh-sweep", "Günther §4.1.2", One, |_| {
            Ok(bvh(SweepBvh::default()))
        }),
        own(Bvh, "bvh-streamed", "Günther §4.2.2", Any, |_| {
            Ok(bvh_streamed(BinCount::ACCURATE))
        }),
        own(Bvh, "bvh-streamed-fast", "Günther §4.2.2", Any, |_| {
            Ok(bvh_streamed(BinCount::FAST))
        }),
        own(
            Bvh,
            "bvh-streamed-thesis",
            "Günther §4.2.2, to the letter",
            One,
            |_| Ok(bvh(FusedBvh::default())),
        ),
        own(Bvh, "bvh-binned", "Wald §3", One, |_| Ok(bvh(BinnedBvh::default()))),
        own(Bvh, "bvh-median", "Wald §2.3", One, |_| Ok(bvh(MedianBvh::default()))),
        own(Bvh, "bvh-hybrid", "Wald §4.1", Any, |_| Ok(bvh(HybridBvh::default()))),
        own(Bvh, "bvh-grid", "Wald §4.2", Any, |_| Ok(bvh(GridBvh::default()))),
        own(Bvh, "bvh-refit", "Günther §2.3", Any, |_| Ok(refit_worker())),
        own(Kd, "kd-sweep", "Günther §4.1.2", One, |_| {
            Ok(kd_worker(KdBuilder::new()))
        }),
        own(Kd, "kd-streamed", "Günther §4.2.1, bins adapt", Any, |_| {
            Ok(kd_worker(StreamedKd::new()))
        }),
        own(Kd, "kd-streamed-thesis", "Günther §4.2.1", Any, |_| {
            Ok(kd_worker(StreamedKd::thesis()))
        }),
    ];
    #[cfg(feature = "peers")]
    all.extend(super::peers::peers());
    all
}

fn bvh(mut builder: impl BvhBuilder + Send + 'static) -> Box<dyn Worker> {
    bvh_worker(move |boxes, settings, tree| builder.build(boxes, settings, tree))
}

fn bvh_streamed(count: BinCount) -> Box<dyn Worker> {
    bvh(StreamedBvh::new(count, SimdLevel::detect()))
}
