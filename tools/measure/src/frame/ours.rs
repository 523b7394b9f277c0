use super::{
    contestant::{Contestant, Tracing},
    crowd::Crowd,
    scene::File,
};
use crate::MeasureError;
use restpose_formats::{
    ModelView, TreeKind,
    rows::{KdNodeRow, KeyBoxRow, WideNodeRow},
};
use restpose_runtime::{Hit, InstanceId, Posing, Ray, Scene, TraceCounters};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// A way in which the runtime can be used.
pub(super) struct Strategy {
    /// As in tables, after `restpose`.
    pub name: &'static str,
    /// Fuzzy trees of the file.
    pub tree: TreeKind,
    /// How its instances are posed.
    pub posing: Posing,
}

const fn strategy(name: &'static str, tree: TreeKind, posing: Posing) -> Strategy {
    Strategy { name, tree, posing }
}

/// All strategies of the runtime, a line each.
pub(super) const STRATEGIES: &[Strategy] = &[
    strategy("restpose-kd", TreeKind::Kd, Posing::Chosen),
    strategy("restpose-kd-recomputed", TreeKind::Kd, Posing::Recomputed),
    strategy("restpose-kd-remembered", TreeKind::Kd, Posing::Remembered),
    strategy("restpose-kd-whole", TreeKind::Kd, Posing::Whole),
    strategy("restpose-wide", TreeKind::Wide, Posing::Chosen),
    strategy("restpose-wide-recomputed", TreeKind::Wide, Posing::Recomputed),
    strategy("restpose-wide-remembered", TreeKind::Wide, Posing::Remembered),
    strategy("restpose-wide-whole", TreeKind::Wide, Posing::Whole),
];

/// The runtime.
pub(super) struct Ours {
    crowd: Arc<Crowd>,
    scene: Scene,
    instances: Vec<InstanceId>,
    step_bytes: usize,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

impl Ours {
    pub(super) fn new(crowd: &Arc<Crowd>, file: &File, strategy: &Strategy) -> Result<Self, MeasureError> {
        let (mut scene, instances) = crowd.scene(&file.asset)?;
        for instance in &instances {
            scene.set_posing(*instance, strategy.posing)?;
        }
        Ok(Self {
            crowd: Arc::clone(crowd),
            scene,
            instances,
            step_bytes: step_bytes(file.asset.model()),
            rays: Vec::new(),
            hits: Vec::new(),
        })
    }
}

/// A node, and where nodes have boxes at keys, those of two keys.
fn step_bytes(model: &ModelView) -> usize {
    match model.meta.tree {
        TreeKind::Kd => size_of::<KdNodeRow>(),
        TreeKind::Wide if model.key_boxes.is_empty() => size_of::<WideNodeRow>(),
        TreeKind::Wide => size_of::<WideNodeRow>() + 2 * size_of::<KeyBoxRow>(),
    }
}

impl Contestant for Ours {
    fn set_rays(&mut self, rays: &[Ray], _tracing: Tracing) {
        self.rays.clear();
        self.rays.extend_from_slice(rays);
        self.hits.resize(rays.len(), None);
    }

    fn frame(&mut self, pose: usize) -> Result<Duration, MeasureError> {
        let start = Instant::now();
        self.crowd.pose(&mut self.scene, &self.instances, pose)?;
        let frame = self.scene.commit();
        let update = start.elapsed();
        frame.closest_hits(&self.rays, &mut self.hits);
        Ok(update)
    }

    fn distances(&self) -> Vec<f32> {
        self.hits
            .iter()
            .map(|hit| hit.map_or(f32::INFINITY, |hit| hit.t))
            .collect()
    }

    fn hits(&self) -> Option<&[Option<Hit>]> {
        Some(&self.hits)
    }

    fn step_bytes(&self) -> usize {
        self.step_bytes
    }

    fn counted(&mut self, pose: usize) -> Result<Option<TraceCounters>, MeasureError> {
        self.crowd.pose(&mut self.scene, &self.instances, pose)?;
        let frame = self.scene.commit();
        // One after the other: from which ray on more is posed depends on how many came before.
        let mut counters = TraceCounters::default();
        for (ray, hit) in self.rays.iter().zip(&mut self.hits) {
            *hit = frame.closest_hit_counted(ray, &mut counters);
        }
        Ok(Some(counters))
    }
}
