use super::{row_count, skeleton::Skeleton};
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
    morph_sets: &[u32],
    cache_rows: &[u32],
) -> Result<(), BakeError> {
    for clip in clips {
        let source = &animation.clips[*clip];
        let channel_first = row_count("channels", model.channels.len())?;
        let (mut start, mut end) = (f32::INFINITY, f32::NEG_INFINITY);
        for channel in &source.channels {
            let target = match channel.target {
                ChannelTarget::Weights => morph_sets[channel.node],
                ChannelTarget::Frame => cache_rows[channel.node],
                _ => skeleton.node_rows[channel.node],
            };
            if target == NONE {
                continue;
            }
            let width = match channel.target {
                ChannelTarget::Rotation => 4,
                ChannelTarget::Weights => model.morph_sets[target as usize].target_count,
                ChannelTarget::Translation | ChannelTarget::Scale => 3,
                ChannelTarget::Frame => 1,
            };
            model.channels.push(ChannelRow {
                target,
                path: channel.target as u32,
                interpolation: channel.interpolation as u32,
                width,
                time_first: row_count("key times", model.key_times.len())?,
                key_count: row_count("key times", channel.times.len())?,
                value_first: row_count("key values", model.key_values.len())?,
                reserved: 0,
            });
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
