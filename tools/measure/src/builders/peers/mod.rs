//! Builders of other projects over the same boxes. What to install stands in `PEERS.md` beside this crate's manifest.
//!
//! Boxes are brought into a peer's own form before a build is timed, and its tree into the runtime's after: so validation,
//! cost and traversal are the same for all.

mod bvh_crate;
mod convert;
mod embree;
mod obvhs;
mod tinybvh;

use super::{
    list::{Builder, Threads},
    tree::TreeKind,
};
use crate::{MeasureError, embree::Quality};
use ::obvhs::BvhBuildParams;

/// All peers, a line each.
pub(super) fn peers() -> Vec<Builder> {
    let peer = |name, source, threads, make| Builder {
        name,
        kind: TreeKind::Bvh,
        source,
        threads,
        is_peer: true,
        make,
    };
    vec![
        peer("embree-low", "Embree 3, Morton order", Threads::Any, |threads| {
            embree::worker(threads, Quality::Low)
        }),
        peer("embree-medium", "Embree 3, binned SAH", Threads::Any, |threads| {
            embree::worker(threads, Quality::Medium)
        }),
        peer("obvhs-fastest", "obvhs 0.4, PLOC", Threads::Any, |_| {
            Ok(obvhs::worker(BvhBuildParams::fastest_build()))
        }),
        peer("obvhs-fast", "obvhs 0.4, PLOC", Threads::Any, |_| {
            Ok(obvhs::worker(BvhBuildParams::fast_build()))
        }),
        peer("obvhs-medium", "obvhs 0.4, PLOC", Threads::Any, |_| {
            Ok(obvhs::worker(BvhBuildParams::medium_build()))
        }),
        peer("bvh-crate", "bvh 0.13, binned SAH", Threads::Any, |_| {
            Ok(bvh_crate::worker())
        }),
        peer("tinybvh", "tinybvh 1.6, binned SAH", tinybvh::THREADS, |_| {
            Ok(tinybvh::worker())
        }),
    ]
}

/// A peer refused to build, or built what is no tree.
fn failed(peer: &'static str, fault: impl Into<String>) -> MeasureError {
    MeasureError::peer(peer, fault)
}
