use super::{
    super::contestant::{Contestant, Tracing},
    skinning::{Scratch, Skinning},
};
use crate::MeasureError;
use restpose_runtime::Ray;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// A peer's trees over posed vertices.
pub(super) trait Structure: Send {
    /// Ways in which it traces.
    fn tracings(&self) -> &'static [Tracing] {
        &[Tracing::Single]
    }

    /// The vertices of all instances, to be posed anew.
    fn vertices(&mut self) -> &mut [[f32; 4]];

    /// Brings its trees up to date with the vertices.
    fn update(&mut self) -> Result<(), MeasureError>;

    /// Takes over rays in its own form. Not timed.
    fn set_rays(&mut self, rays: &[Ray], tracing: Tracing);

    /// Traces the rays.
    fn trace(&mut self) -> Result<(), MeasureError>;

    /// As [`Contestant::distances`].
    fn distances(&self) -> Vec<f32>;
}

/// A peer with all vertices posed in every frame.
pub(super) struct Skinned {
    skinning: Arc<Skinning>,
    scratch: Scratch,
    structure: Box<dyn Structure>,
}

impl Skinned {
    pub(super) fn new(skinning: &Arc<Skinning>, structure: Box<dyn Structure>) -> Self {
        Self {
            skinning: Arc::clone(skinning),
            scratch: Scratch::default(),
            structure,
        }
    }
}

impl Contestant for Skinned {
    fn tracings(&self) -> &'static [Tracing] {
        self.structure.tracings()
    }

    fn set_rays(&mut self, rays: &[Ray], tracing: Tracing) {
        self.structure.set_rays(rays, tracing);
    }

    fn frame(&mut self, pose: usize) -> Result<Duration, MeasureError> {
        let start = Instant::now();
        self.skinning
            .vertices_into(pose, &mut self.scratch, self.structure.vertices());
        self.structure.update()?;
        let update = start.elapsed();
        self.structure.trace()?;
        Ok(update)
    }

    fn distances(&self) -> Vec<f32> {
        self.structure.distances()
    }
}
