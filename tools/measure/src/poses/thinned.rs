use super::candidate::Candidate;
use crate::MeasureError;
use restpose_bake::{
    BakeSettings, PoseSpace,
    import::{Animation, Channel, ChannelTarget, Clip},
};
use restpose_formats::{
    Bounds, Model, ModelView,
    rows::{ClipRow, Interpolation, NONE, STRETCHES},
};
use restpose_runtime::{NodeLocal, Pose, PoseEvaluator};
use std::collections::BTreeMap;

/// No step between two samples of a clip is longer than the clip: only its ends are.
const LONGEST_STEP: f64 = f32::MAX as f64;

/// Bakes boxes around samples of all clips every `step` seconds, and not around what is at key times, which
/// [`bake`](restpose_bake::bake) always samples. `sampled` is a bake of `animation` for all clips.
///
/// The samples are the keys of a clip of their own, which is the pose space and leaves the file again.
pub(super) fn thinned(animation: &Animation, sampled: &ModelView, step: f64) -> Result<Candidate, MeasureError> {
    let mut thinned = animation.clone();
    thinned.clips.push(sampled_clip(animation, sampled, step));
    let settings = BakeSettings {
        pose_space: PoseSpace::Clip(thinned.clips[animation.clips.len()].name.clone()),
        sample_step_seconds: LONGEST_STEP,
        bounds: Bounds::Sampled,
        tree: sampled.meta.tree,
        ..BakeSettings::default()
    };
    let mut candidate = Candidate::with_changes(&thinned, 0, &settings, remove_last_clip)?;
    candidate.file.pose_space = "clips";
    Ok(candidate)
}

/// Whether [`thinned`] can resample all that the clips move: nodes, but neither morph weights nor vertex caches.
pub(super) fn can_be_thinned(animation: &Animation) -> bool {
    let mut channels = animation.clips.iter().flat_map(|clip| &clip.channels);
    channels.all(|channel| !matches!(channel.target, ChannelTarget::Weights | ChannelTarget::Frame))
}

/// A clip that stands still in one sample after the other.
fn sampled_clip(animation: &Animation, model: &ModelView, step: f64) -> Clip {
    // Only what a clip moves: whether a clip moves it is what decides a part's class.
    let moved = animation.clips.iter().flat_map(|clip| &clip.channels);
    let mut values: BTreeMap<(u32, usize), Vec<f32>> = moved
        .map(|channel| ((channel.target as u32, channel.node), Vec::new()))
        .collect();
    let mut add = |target: ChannelTarget, node: usize, value: &[f64]| {
        if let Some(all) = values.get_mut(&(target as u32, node)) {
            all.extend(value.iter().map(|x| *x as f32));
        }
    };
    let times = sample_times(model, step);
    let (mut evaluator, mut pose) = (PoseEvaluator::default(), Pose::default());
    for (clip, seconds) in &times {
        evaluator.evaluate_with(model, Some(*clip), *seconds, &mut pose, |node, local| {
            if let NodeLocal::Trs {
                translation,
                rotation,
                scale,
            } = local
            {
                let node = model.nodes[node].source_node as usize;
                add(ChannelTarget::Translation, node, translation);
                add(ChannelTarget::Rotation, node, rotation);
                add(ChannelTarget::Scale, node, scale);
            }
        });
    }
    let mut name = "samples".to_owned();
    while animation.clips.iter().any(|clip| clip.name == name) {
        name.push('+');
    }
    let channel = |((target, node), values): ((u32, usize), Vec<f32>)| {
        Some(Channel {
            node,
            target: ChannelTarget::from_number(target)?,
            interpolation: Interpolation::Step,
            times: (0..times.len()).map(|sample| sample as f32).collect(),
            values,
        })
    };
    let kept = values.into_iter().filter(|(_, values)| !values.is_empty());
    Clip {
        name,
        channels: kept.filter_map(channel).collect(),
    }
}

/// Every `step` seconds of each clip, and its end.
fn sample_times(model: &ModelView, step: f64) -> Vec<(usize, f32)> {
    let times = |(clip, row): (usize, &ClipRow)| {
        let (start, end) = (f64::from(row.start_seconds), f64::from(row.end_seconds));
        let steps = ((end - start) / step).ceil() as usize;
        (0..=steps).map(move |number| (clip, (start + number as f64 * step).min(end) as f32))
    };
    model.clips.iter().enumerate().flat_map(times).collect()
}

fn remove_last_clip(model: &mut Model) {
    let Some(clip) = model.clips.pop() else { return };
    if !model.clip_bounds.is_empty() {
        let first = model.clips.len() * STRETCHES;
        model.clip_bounds.drain(first..first + STRETCHES);
    }
    model.meta.clip_names.pop();
    let own = &model.channels[clip.channel_first as usize..];
    let times = own.iter().map(|channel| channel.time_first).min();
    let values = own.iter().map(|channel| channel.value_first).min();
    model.channels.truncate(clip.channel_first as usize);
    if let (Some(times), Some(values)) = (times, values) {
        model.key_times.truncate(times as usize);
        model.key_values.truncate(values as usize);
    }
    model.samples.retain(|sample| sample.clip == NONE);
}
