//! What a whole frame costs against its number of rays: set pose, update, trace.
//!
//! Contestants get the same poses and the same rays, and take turns. A turn is a frame of every pose, one after the other,
//! so that each is as warm as it is in a program that does nothing else. Before that all hits are compared: those of the
//! runtime's strategies with each other bit for bit and, for a subset, with brute force; those of peers, whose triangle tests
//! round otherwise, by distance.

mod contest;
mod contestant;
mod contestants;
mod crossovers;
mod crowd;
mod glance;
mod ours;
mod page;
#[cfg(feature = "peers")]
mod peers;
mod ray_sets;
mod reference;
mod report;
mod scene;
mod settings;
mod text;

pub use contestants::strategy_names;
pub use crossovers::Crossover;
pub use glance::Glance;
pub use page::page;
pub use ray_sets::RayKind;
pub use report::{FixedCost, FrameCost, FrameCounts, FrameReport};
pub use scene::FrameScene;
pub use settings::{FrameSettings, Palettes};

use crate::{MeasureError, thread_pools::thread_pools};
use contest::Contest;
use crossovers::crossovers;
use crowd::Crowd;
use ours::STRATEGIES;
use reference::Reference;
use restpose_bake::Progress;
use std::sync::Arc;

/// Measures frames of a scene.
///
/// Guarantee: all numbers but times and memory are the same in every run with the same settings.
///
/// # Errors
/// [`MeasureError`]: settings out of range, a source that does not bake, or hits that disagree.
pub fn measure_frame(
    scene: &mut FrameScene,
    settings: &FrameSettings,
    progress: &dyn Progress,
) -> Result<FrameReport, MeasureError> {
    settings.check()?;
    let pools = thread_pools(&settings.threads)?;
    scene.bake(settings, progress)?;
    let scene = &*scene;
    // Before the measurement has taken memory and given it back.
    let glances = glance::glances(scene, settings)?;
    let mut chosen = STRATEGIES.iter().filter(|strategy| settings.chosen(strategy.name));
    let Some(file) = chosen.find_map(|strategy| scene.file(strategy.tree)) else {
        return Err(MeasureError::NoStrategy {
            scene: scene.name.clone(),
        });
    };
    let crowd = Arc::new(Crowd::new(
        &file.asset,
        scene.instances,
        settings.poses,
        settings.palettes,
    )?);
    let reference = Reference::new(&crowd, settings)?;
    let mut contest = Contest::new(scene, &crowd, &reference, settings);
    progress.stage("measure", contest.steps(pools.len()));
    for pool in &pools {
        contest.run(scene, pool, progress)?;
    }
    let frames = contest.rows;
    Ok(FrameReport {
        schema: "restpose.measure.frame.2",
        settings: settings.clone(),
        crossovers: crossovers(&frames),
        frames,
        glances,
        brute_force_rays: reference.brute_force_rays,
    })
}
