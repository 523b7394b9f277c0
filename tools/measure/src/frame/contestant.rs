use crate::MeasureError;
use restpose_runtime::{Hit, Ray, TraceCounters};
use std::time::Duration;

/// Somebody who can make and trace frames of a crowd.
pub(super) trait Contestant: Send {
    /// Ways in which it traces.
    fn tracings(&self) -> &'static [Tracing] {
        &[Tracing::Single]
    }

    /// Takes over the rays of the frames to come, in its own form. Not timed.
    fn set_rays(&mut self, rays: &[Ray], tracing: Tracing);

    /// A whole frame on the threads of the present pool: poses all instances, brings its trees up to date, traces the rays.
    /// Gives the time until rays could be traced.
    fn frame(&mut self, pose: usize) -> Result<Duration, MeasureError>;

    /// The distances of the last frame's hits in lengths of the rays' directions, infinite where nothing was hit.
    fn distances(&self) -> Vec<f32>;

    /// What the last frame hit, of the runtime's contestants.
    fn hits(&self) -> Option<&[Option<Hit>]> {
        None
    }

    /// Most bytes that a step reads which is counted in [`Contestant::counted`].
    fn step_bytes(&self) -> usize {
        0
    }

    /// A frame on one thread that is counted instead of timed; `None` where nothing counts.
    fn counted(&mut self, _pose: usize) -> Result<Option<TraceCounters>, MeasureError> {
        Ok(None)
    }
}

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tracing {
    /// As the contestant is asked for them most often: one by one or as a batch.
    Single,
    /// As packets of neighbours.
    Packets,
}
