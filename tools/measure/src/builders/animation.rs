use super::{
    follower::{Follower, FrameWorker, followers},
    list::Builder,
    report::{AnimationFigures, FrameFigures},
    scene::BuilderScene,
    scenes::boxes,
    settings::BuildersSettings,
    tree::TreeKind,
    worker::Worker,
};
use crate::{MeasureError, statistics::median, thread_pools::thread_pools};
use restpose_bake::Progress;
use restpose_builders::kd::TrackingStats;
use restpose_runtime::build::CheckedBoxes;
use std::time::Instant;

/// A reference builder, which builds every frame afresh.
struct Reference<'a> {
    builder: &'a Builder,
    worker: Box<dyn Worker>,
    /// Per frame, a time per pass.
    seconds: Vec<Vec<f64>>,
    costs: Vec<f64>,
}

/// What a follower did.
struct Followed {
    follower: Follower,
    /// Per frame, a time per pass.
    seconds: Vec<Vec<f64>>,
    costs: Vec<f64>,
    tracking: Vec<Option<TrackingStats>>,
}

/// Builders that follow an animation from frame to frame beside those of the same kind of tree, out of `builders`, that
/// build each frame afresh: passes over all frames, on one thread, in turns. Trees of the first pass are validated.
///
/// Source: Hussain and Grahn, Table I.
pub(super) fn follow_animation(
    scene: &BuilderScene,
    builders: &[Builder],
    settings: &BuildersSettings,
    progress: &dyn Progress,
) -> Result<(Vec<AnimationFigures>, Vec<FrameFigures>), MeasureError> {
    let frames = &scene.frames;
    let mut references: Vec<Reference> = Vec::new();
    let mut followed = Vec::new();
    for follower in followers() {
        let Some(builder) = builders.iter().find(|builder| builder.kind == follower.kind) else {
            continue;
        };
        if !settings.builders.iter().any(|name| name == follower.name) || builder.name == follower.name {
            continue;
        }
        if !references
            .iter()
            .any(|reference| reference.builder.kind == builder.kind)
        {
            references.push(Reference {
                builder,
                worker: (builder.make)(1)?,
                seconds: vec![Vec::new(); frames.len()],
                costs: Vec::new(),
            });
        }
        followed.push(Followed {
            follower,
            seconds: vec![Vec::new(); frames.len()],
            costs: Vec::new(),
            tracking: Vec::new(),
        });
    }
    let pool = &thread_pools(&[1])?[0];
    let start = Instant::now();
    for pass in 0..settings.repeats {
        if pass > 0 && start.elapsed().as_secs_f64() > settings.seconds {
            break;
        }
        let mut workers: Vec<Box<dyn FrameWorker>> = followed.iter().map(|own| (own.follower.make)()).collect();
        for (number, triangles) in frames.iter().enumerate() {
            let boxes = boxes(triangles);
            let boxes = CheckedBoxes::new(&boxes).map_err(|source| MeasureError::Boxes {
                scene: format!("{}, frame {number}", scene.name),
                source,
            })?;
            let invalid = |builder: &str, source| MeasureError::Tree {
                scene: format!("{}, frame {number}", scene.name),
                builder: builder.to_owned(),
                threads: 1,
                source,
            };
            for reference in &mut references {
                let worker = &mut reference.worker;
                worker.prepare(boxes)?;
                if pass == 0 && number == 0 {
                    // Followers begin with a first build by nature, builders that keep their memory do not.
                    pool.install(|| worker.build(boxes))?;
                }
                let seconds = pool.install(|| timed(|| worker.build(boxes)))?;
                reference.seconds[number].push(seconds);
                let tree = worker.take_tree()?;
                if pass == 0 {
                    tree.validate(boxes.get())
                        .map_err(|source| invalid(reference.builder.name, source))?;
                    reference.costs.push(tree.sah_cost());
                }
            }
            for (own, worker) in followed.iter_mut().zip(&mut workers) {
                let seconds = pool.install(|| timed(|| worker.build(boxes)))?;
                own.seconds[number].push(seconds);
                if pass == 0 {
                    let tree = worker.tree();
                    tree.validate(boxes.get())
                        .map_err(|source| invalid(own.follower.name, source))?;
                    own.costs.push(tree.sah_cost());
                    own.tracking.push(worker.tracking());
                }
            }
            if pass == 0 {
                progress.advance(1);
            }
        }
    }
    Ok(figures(scene, &mut references, followed))
}

/// Steps of progress.
pub(super) fn animation_steps(scene: &BuilderScene) -> usize {
    scene.frames.len()
}

fn timed(build: impl FnOnce() -> Result<(), MeasureError>) -> Result<f64, MeasureError> {
    let start = Instant::now();
    build()?;
    Ok(start.elapsed().as_secs_f64())
}

fn figures(
    scene: &BuilderScene,
    references: &mut [Reference],
    followed: Vec<Followed>,
) -> (Vec<AnimationFigures>, Vec<FrameFigures>) {
    let medians = |seconds: &mut Vec<Vec<f64>>| -> Vec<f64> { seconds.iter_mut().map(|own| median(own)).collect() };
    let exact: Vec<(TreeKind, &'static str, Vec<f64>, &[f64])> = references
        .iter_mut()
        .map(|own| {
            (
                own.builder.kind,
                own.builder.name,
                medians(&mut own.seconds),
                &own.costs[..],
            )
        })
        .collect();
    let (mut animations, mut all_frames) = (Vec::new(), Vec::new());
    for mut own in followed {
        let seconds = medians(&mut own.seconds);
        // There is one for each follower.
        let Some((_, reference, exact_seconds, exact_costs)) =
            exact.iter().find(|(kind, ..)| *kind == own.follower.kind)
        else {
            continue;
        };
        let first = all_frames.len();
        for (frame, seconds) in seconds.iter().enumerate() {
            let tracking = own.tracking[frame];
            all_frames.push(FrameFigures {
                scene: scene.name.clone(),
                frame: frame as u64,
                builder: own.follower.name,
                seconds: *seconds,
                exact_seconds: exact_seconds[frame],
                sah_cost: own.costs[frame],
                sah_relative: exact_costs[frame] / own.costs[frame],
                tracked_fraction: tracking.map(|own| own.tracked_share()),
                prediction_error: tracking.map(|own| own.prediction_error()),
                tracked_steps: tracking.map(|own| own.steps_per_tracked_node()),
                untracked_steps: tracking.map(|own| own.steps_per_untracked_node()),
            });
        }
        let running = &all_frames[first + 1..];
        let of = |value: fn(&FrameFigures) -> f64| median(&mut running.iter().map(value).collect::<Vec<f64>>());
        let mean = |value: fn(&FrameFigures) -> Option<f64>| {
            let values: Vec<f64> = running.iter().filter_map(value).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        animations.push(AnimationFigures {
            scene: scene.name.clone(),
            triangles: scene.triangles.len() as u64,
            frames: scene.frames.len() as u64,
            builder: own.follower.name,
            reference,
            exact_seconds: of(|frame| frame.exact_seconds),
            initial_seconds: all_frames[first].seconds,
            running_seconds: of(|frame| frame.seconds),
            reduction: of(|frame| 1.0 - frame.seconds / frame.exact_seconds),
            sah_relative: mean(|frame| Some(frame.sah_relative)).unwrap_or(f64::NAN),
            sah_relative_least: running
                .iter()
                .fold(f64::INFINITY, |least, frame| least.min(frame.sah_relative)),
            tracked_fraction: mean(|frame| frame.tracked_fraction),
            prediction_error: mean(|frame| frame.prediction_error),
            tracked_steps: mean(|frame| frame.tracked_steps),
            untracked_steps: mean(|frame| frame.untracked_steps),
        });
    }
    (animations, all_frames)
}
