use super::{geometry::Geometry, row_count, skeleton::Skeleton};
use crate::{
    BakeError,
    import::{Animation, ChannelTarget},
};
use restpose_formats::{
    Model,
    rows::{ChannelRow, ClipRow, NONE},
};

/// Adds the selected clips with the channels that move nodes and morph sets of the file.
pub(crate) fn add_clips(
    model: &mut Model,
    animation: &Animation,
    clips: &[usize],
    skeleton: &Skeleton,
    geometry: &Geometry,
) -> Result<(), BakeError> {
    for clip in clips {
        let source = &animation.clips[*clip];
        let channel_first = row_count("channels", model.channels.len())?;
        let (mut start, mut end) = (f32::INFINITY, f32::NEG_INFINITY);
        for channel in &source.channels {
            let targets = match channel.target {
                ChannelTarget::Weights => &geometry.morph_sets[channel.node..=channel.node],
                // One cache of the source can move several parts, each with a row of its own.
                ChannelTarget::Frame => &geometry.cache_rows[channel.node],
                _ => &skeleton.node_rows[channel.node..=channel.node],
            };
            let targets: Vec<u32> = targets.iter().copied().filter(|target| *target != NONE).collect();
            let Some(target) = targets.first() else {
                continue;
            };
            let width = match channel.target {
                ChannelTarget::Rotation => 4,
                ChannelTarget::Weights => model.morph_sets[*target as usize].target_count,
                ChannelTarget::Translation | ChannelTarget::Scale => 3,
                ChannelTarget::Frame => 1,
            };
            let row = ChannelRow {
                target: *target,
                path: channel.target as u32,
                interpolation: channel.interpolation as u32,
                width,
                time_first: row_count("key times", model.key_times.len())?,
                key_count: row_count("key times", channel.times.len())?,
                value_first: row_count("key values", model.key_values.len())?,
                reserved: 0,
            };
            model
                .channels
                .extend(targets.iter().map(|target| ChannelRow { target: *target, ..row }));
            start = channel.times.iter().copied().fold(start, f32::min);
            end = channel.times.iter().copied().fold(end, f32::max);
            model.key_times.extend_from_slice(&channel.times);
            model.key_values.extend_from_slice(&channel.values);
        }
        let channel_count = row_count("channels", model.channels.len())? - channel_first;
        let (start_seconds, end_seconds) = if channel_count == 0 { (0.0, 0.0) } else { (start, end) };
        model.clips.push(ClipRow {
            start_seconds,
            end_seconds,
            channel_first,
            channel_count,
        });
        model.meta.clip_names.push(source.label(*clip));
    }
    Ok(())
}
