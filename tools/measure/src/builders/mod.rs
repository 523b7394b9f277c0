//! Every tree builder over the same boxes: how fast it builds, and how good its tree is.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, Tables 4.1 and 4.2; Wald, *On fast Construction of SAH-based
//! Bounding Volume Hierarchies*, 2007, Table 1; Hussain and Grahn, *Tracking Data Structures
//! Coherency in Animated Ray Tracing*, Table I. Differs: both sides of every comparison are measured here, in turns; a
//! tree's quality is its cost relative to the exact builder's, and the time of rays through it, too; trees of all builders
//! are traced by one traversal per kind of tree.

mod animation;
mod contest;
mod follower;
mod key_frames;
mod list;
mod page;
#[cfg(feature = "peers")]
mod peers;
mod rays;
mod render;
mod report;
mod sampled_frames;
mod scene;
mod scenes;
mod settings;
mod text;
mod theirs;
mod traversal;
mod traversal_bvh;
mod traversal_kd;
mod tree;
mod worker;

pub use page::page;
pub use report::{AnimationFigures, BuildFigures, BuildersReport, FrameFigures};
pub use scene::BuilderScene;
pub use scenes::{Generated, GeneratedKind};
pub use settings::{BuildersSettings, builder_names};
pub use theirs::TheirFigures;
pub use traversal::TreeHit;
pub use tree::TreeFault;

use crate::MeasureError;
use animation::{animation_steps, follow_animation};
use contest::{Contest, contestant_count};
use restpose_bake::Progress;
use scenes::shuffle;
use theirs::their_figures;

/// Builds trees over a scene by all builders, and traces the same rays through all of them.
///
/// Every tree is validated, and all trees' hits are compared, before anything is timed: with each other, and for a subset
/// with brute force, bit for bit.
///
/// Guarantee: all numbers but times and memory are the same in every run with the same settings, but for peers.
///
/// # Errors
/// [`MeasureError`]: settings out of range; boxes that no tree can be built over; a tree that is none, differs from one
/// number of threads to another, or misses a hit.
pub fn measure_builders(
    scene: &BuilderScene,
    settings: &BuildersSettings,
    progress: &dyn Progress,
) -> Result<BuildersReport, MeasureError> {
    settings.check()?;
    let builders = settings.chosen();
    let orders: &[bool] = if settings.shuffled { &[false, true] } else { &[false] };
    let steps = contestant_count(&builders, settings) + settings.repeats as usize;
    progress.stage("measure", (steps * orders.len() + animation_steps(scene)) as u64);
    let mut report = BuildersReport {
        schema: "restpose.measure.builders.1",
        settings: settings.clone(),
        builds: Vec::new(),
        animations: Vec::new(),
        animation_frames: Vec::new(),
        theirs: their_figures(),
        brute_force_rays: 0,
    };
    for shuffled in orders {
        let mut reordered = Vec::new();
        let triangles = if *shuffled {
            reordered.clone_from(&scene.triangles);
            shuffle(&mut reordered, settings.seed);
            &reordered
        } else {
            &scene.triangles
        };
        let contest = Contest {
            scene: &scene.name,
            triangles,
            shuffled: *shuffled,
            settings,
            progress,
        };
        let (rows, brute_force_rays) = contest.run(&builders)?;
        report.builds.extend(rows);
        report.brute_force_rays += brute_force_rays;
    }
    if !scene.frames.is_empty() {
        (report.animations, report.animation_frames) = follow_animation(scene, &builders, settings, progress)?;
    }
    Ok(report)
}
