use crate::{BakeError, BakeSettings};
use restpose_formats::{
    Model,
    rows::{ChannelRow, NONE, Path, SampleRow},
};

/// Samples of one clip that a bake takes: half an hour at sixty a second. Of fifty bones a sampled pose
/// is 7 kB, and a span to the next 18 kB.
const SAMPLE_LIMIT: u64 = 108_000;

/// The sampled poses: the pose without any clip, then per clip of the pose space every key time of its channels and steps of at most
/// `sample_step_seconds` from its start to its end. Each clip's times ascend and differ. `clips` are those clips' rows,
/// ascending.
///
/// Differs from Günther §3.4.2, who samples at random: clips are curves, not volumes, and extremes sit at keys.
pub(crate) fn sample_rows(
    model: &Model,
    clips: &[usize],
    settings: &BakeSettings,
) -> Result<Vec<SampleRow>, BakeError> {
    let mut rows = vec![SampleRow {
        clip: NONE,
        seconds: 0.0,
    }];
    for (clip, row) in clips.iter().map(|clip| (*clip, &model.clips[*clip])) {
        let all = &model.channels[row.channel_first as usize..][..row.channel_count as usize];
        // Boxes of vertex caches hold between keys without samples.
        let channels: Vec<&ChannelRow> = all
            .iter()
            .filter(|channel| channel.path != Path::Frame as u32)
            .collect();
        if channels.is_empty() {
            continue;
        }
        let (start, end) = (f64::from(row.start_seconds), f64::from(row.end_seconds));
        let steps = ((end - start) / settings.sample_step_seconds).ceil();
        let keys: u64 = channels.iter().map(|channel| u64::from(channel.key_count)).sum();
        // The cast saturates.
        let count = (steps as u64).saturating_add(keys);
        if count > SAMPLE_LIMIT {
            let clip = model.meta.clip_names[clip].clone();
            return Err(BakeError::TooManySamples {
                clip,
                found: count,
                limit: SAMPLE_LIMIT,
            });
        }
        let mut times: Vec<f32> = (0..steps as u64)
            .map(|step| (start + step as f64 * settings.sample_step_seconds).min(end) as f32)
            .chain([row.end_seconds])
            .collect();
        for channel in channels {
            times.extend_from_slice(&model.key_times[channel.time_first as usize..][..channel.key_count as usize]);
        }
        times.sort_by(f32::total_cmp);
        times.dedup();
        rows.extend(times.into_iter().map(|seconds| SampleRow {
            clip: clip as u32,
            seconds,
        }));
    }
    Ok(rows)
}
