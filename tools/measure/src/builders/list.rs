//! All builders that are measured, a line each: a new one joins all tables by joining the list.

use super::{
    tree::TreeKind,
    worker::{Worker, kd_worker},
};
use crate::MeasureError;
use restpose_runtime::build::{KdBuilder, KdSettings};

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

use Threads::One;
use TreeKind::Kd;

/// All builders. The first of each kind is the one that the others are compared with.
pub(super) fn builders() -> Vec<Builder> {
    let own = |name, kind, source, threads, make| Builder {
        name,
        kind,
        source,
        threads,
        is_peer: false,
        make,
    };
    let mut all = vec![own("kd-sweep", Kd, "Günther §4.1.2", One, |_| {
        let mut builder = KdBuilder::new();
        Ok(kd_worker(move |boxes, tree| {
            builder.build(boxes.get(), &KdSettings::default(), tree);
        }))
    })];
    #[cfg(feature = "peers")]
    all.extend(super::peers::peers());
    all
}
