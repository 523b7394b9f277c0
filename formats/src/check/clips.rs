use super::{
    numbers::{finite, index, reserved},
    row,
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ChannelRow, ClipRow, Interpolation, NONE, NodeRow, Path},
};
use std::ops::Range;

/// Clips tile the channels; channels point at what they can move and at keys in order; clip times are those of the
/// keys. Skeleton, morph sets and caches have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    for (at, time) in view.key_times.iter().enumerate() {
        finite(SectionKind::KeyTimes, at, "time", &[*time])?;
    }
    for (at, value) in view.key_values.iter().enumerate() {
        finite(SectionKind::KeyValues, at, "value", &[*value])?;
    }
    let breaks = time_breaks(view.key_times);
    // Clip that last moved each property: three per node, then one per morph set and cache.
    let property_count = view.nodes.len() * 3 + view.morph_sets.len() + view.caches.len();
    let mut moved_last = vec![usize::MAX; property_count];
    let mut channels = Tiling::new(SectionKind::Channels, view.channels.len());
    for (at, clip) in view.clips.iter().enumerate() {
        let range = channels.take(
            SectionKind::Clips,
            at,
            "channel_first",
            clip.channel_first,
            clip.channel_count,
        )?;
        for channel in range.clone() {
            let property = check_channel(view, channel, &breaks)?;
            if std::mem::replace(&mut moved_last[property], at) == at {
                return Err(row(SectionKind::Channels, channel, RowFault::RepeatedChannel));
            }
        }
        check_clip_times(view, at, clip, range)?;
    }
    channels.finish()?;
    for (at, sample) in view.samples.iter().enumerate() {
        let section = SectionKind::Samples;
        finite(section, at, "seconds", &[sample.seconds])?;
        if sample.clip != NONE {
            index(section, at, "clip", sample.clip, view.clips.len())?;
        }
    }
    Ok(())
}

/// The rows of the key-time section whose time is not below the next one's, ascending. Channels may share times, so
/// walking each channel's times could take quadratic time in a hostile file.
fn time_breaks(times: &[f32]) -> Vec<usize> {
    let pairs = times.windows(2).enumerate();
    pairs.filter(|(_, pair)| pair[0] >= pair[1]).map(|(at, _)| at).collect()
}

/// Checks a channel and returns the number of the property that it moves.
fn check_channel(view: &ModelView<'_>, at: usize, breaks: &[usize]) -> Result<usize, FormatError> {
    let section = SectionKind::Channels;
    let channel = &view.channels[at];
    reserved(section, at, "reserved", &[channel.reserved])?;
    let (path, interpolation) = decode(at, channel)?;
    let target = |limit| index(section, at, "target", channel.target, limit);
    let (first_set, first_cache) = (view.nodes.len() * 3, view.nodes.len() * 3 + view.morph_sets.len());
    let (property, width) = match path {
        Path::Weights => {
            let set = target(view.morph_sets.len())?;
            (first_set + set, view.morph_sets[set].target_count)
        }
        Path::Frame => (first_cache + target(view.caches.len())?, 1),
        Path::Translation | Path::Rotation | Path::Scale => {
            let node = target(view.nodes.len())?;
            if view.nodes[node].local_kind == NodeRow::MATRIX {
                let fault = RowFault::MatrixNodeAnimated { node: channel.target };
                return Err(row(section, at, fault));
            }
            (node * 3 + path as usize, if path == Path::Rotation { 4 } else { 3 })
        }
    };
    if width == 0 {
        return Err(row(section, at, RowFault::EmptyRange { field: "width" }));
    }
    if channel.width != width {
        let fault = RowFault::Count {
            field: "width",
            found: u64::from(channel.width),
            expected: u64::from(width),
        };
        return Err(row(section, at, fault));
    }
    check_times(view, at, channel, breaks)?;
    check_values(view, at, channel, interpolation)?;
    Ok(property)
}

fn decode(at: usize, channel: &ChannelRow) -> Result<(Path, Interpolation), FormatError> {
    let unknown = |field, found, limit| {
        let fault = RowFault::UnknownNumber { field, found, limit };
        row(SectionKind::Channels, at, fault)
    };
    let path = Path::from_number(channel.path).ok_or_else(|| unknown("path", channel.path, Path::ALL.len() as u32))?;
    let limit = Interpolation::ALL.len() as u32;
    let interpolation = Interpolation::from_number(channel.interpolation)
        .ok_or_else(|| unknown("interpolation", channel.interpolation, limit))?;
    Ok((path, interpolation))
}

fn check_times(view: &ModelView<'_>, at: usize, channel: &ChannelRow, breaks: &[usize]) -> Result<(), FormatError> {
    let section = SectionKind::Channels;
    if channel.key_count == 0 {
        return Err(row(section, at, RowFault::EmptyRange { field: "key_count" }));
    }
    let (first, count) = (u64::from(channel.time_first), u64::from(channel.key_count));
    let limit = view.key_times.len() as u64;
    if first + count > limit {
        let fault = RowFault::RangeOutOfBounds {
            field: "time_first",
            first,
            count,
            limit,
        };
        return Err(row(section, at, fault));
    }
    let first = first as usize;
    match breaks.get(breaks.partition_point(|key| *key < first)) {
        Some(key) if *key < first + count as usize - 1 => {
            let fault = RowFault::TimesNotIncreasing {
                key: (*key - first) as u64,
            };
            Err(row(section, at, fault))
        }
        _ => Ok(()),
    }
}

fn check_values(
    view: &ModelView<'_>,
    at: usize,
    channel: &ChannelRow,
    interpolation: Interpolation,
) -> Result<(), FormatError> {
    let first = u64::from(channel.value_first);
    let limit = view.key_values.len() as u64;
    let per_key = u64::from(channel.width) * u64::from(interpolation.values_per_key());
    let count = u64::from(channel.key_count).saturating_mul(per_key);
    if first.saturating_add(count) <= limit {
        return Ok(());
    }
    let fault = RowFault::RangeOutOfBounds {
        field: "value_first",
        first,
        count,
        limit,
    };
    Err(row(SectionKind::Channels, at, fault))
}

/// A clip spans its channels' keys exactly; one without channels begins and ends at zero.
fn check_clip_times(
    view: &ModelView<'_>,
    at: usize,
    clip: &ClipRow,
    channels: Range<usize>,
) -> Result<(), FormatError> {
    let mut span: Option<(f32, f32)> = None;
    for channel in &view.channels[channels] {
        let first = channel.time_first as usize;
        let start = view.key_times[first];
        let end = view.key_times[first + channel.key_count as usize - 1];
        span = Some(span.map_or((start, end), |(s, e)| (s.min(start), e.max(end))));
    }
    let (start, end) = span.unwrap_or((0.0, 0.0));
    let fields = [
        ("start_seconds", clip.start_seconds, start),
        ("end_seconds", clip.end_seconds, end),
    ];
    for (field, found, expected) in fields {
        finite(SectionKind::Clips, at, field, &[found])?;
        if found != expected {
            let fault = RowFault::ClipTime { field, found, expected };
            return Err(row(SectionKind::Clips, at, fault));
        }
    }
    Ok(())
}
