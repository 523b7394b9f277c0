use crate::spread::spread;
use restpose_formats::{
    ModelView,
    rows::{ChannelRow, Path},
};

/// A time of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClipTime {
    pub seconds: f32,
    /// Whether a channel has a key at this time.
    pub at_key: bool,
    /// Frame of the first vertex cache that the clip plays.
    pub cache_frame: Option<f64>,
}

/// Up to `count` times spread evenly over the keys of a clip: every other one at a key, the others in the middle between
/// a key and the next.
pub(super) fn clip_times(model: &ModelView, clip: usize, count: usize) -> Vec<ClipTime> {
    let channels = channels(model, clip);
    let mut keys: Vec<f32> = channels
        .iter()
        .flat_map(|channel| times(model, channel))
        .copied()
        .collect();
    keys.sort_by(f32::total_cmp);
    keys.dedup();
    let frames = channels.iter().find(|channel| channel.path == Path::Frame as u32);
    let time = |(order, key): (usize, usize)| {
        let here = keys[key];
        let next = keys.get(key + 1).filter(|_| order % 2 == 1);
        let seconds = next.map_or(here, |next| ((f64::from(here) + f64::from(*next)) / 2.0) as f32);
        ClipTime {
            seconds,
            at_key: seconds == here || Some(&seconds) == next,
            cache_frame: frames.map(|channel| frame_at(model, channel, seconds)),
        }
    };
    spread(count, keys.len()).into_iter().enumerate().map(time).collect()
}

fn channels<'a>(model: &'a ModelView, clip: usize) -> &'a [ChannelRow] {
    let row = &model.clips[clip];
    &model.channels[row.channel_first as usize..][..row.channel_count as usize]
}

fn times<'a>(model: &'a ModelView, channel: &ChannelRow) -> &'a [f32] {
    &model.key_times[channel.time_first as usize..][..channel.key_count as usize]
}

/// The value of a channel of width 1, linear between its keys.
fn frame_at(model: &ModelView, channel: &ChannelRow, seconds: f32) -> f64 {
    let times = times(model, channel);
    let values = &model.key_values[channel.value_first as usize..][..times.len()];
    let next = times
        .partition_point(|time| *time <= seconds)
        .clamp(1, times.len().max(2) - 1);
    let (Some(end), begin) = (times.get(next), times[next - 1]) else {
        return f64::from(values[0]);
    };
    let share = (f64::from(seconds) - f64::from(begin)) / (f64::from(*end) - f64::from(begin));
    let (a, b) = (f64::from(values[next - 1]), f64::from(values[next]));
    a + share.clamp(0.0, 1.0) * (b - a)
}
