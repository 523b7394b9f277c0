//! The times of a stretch as spans.
//!
//! # Why they hold every time
//!
//! Times are `f32`, and which stretch one is in is computed in `f32` ([`ClipRow::stretch`]). That never falls as times
//! grow, so bisection over all numbers finds the first time and the last one of a stretch, exactly and whatever the
//! computation rounds. Before the clip's first key, and after its last one, it stands still as at these keys, so times
//! there are taken as these.
//!
//! Between the two ends, keys begin spans: no span has a key inside. A channel that jumps does so at a key, where a span that
//! begins with it has the key's own value, and one that ends with it what the channel comes from. All times of a
//! span are between its ends, or begin it, where it is smooth; only that of the stretch's own end may be a key at which
//! something jumps that no other span begins with, so it is a span of its own then.

use restpose_formats::{Model, rows::ClipRow};

/// Times of all keys of a clip, ascending, each once.
pub(super) fn key_times(model: &Model, clip: usize) -> Vec<f32> {
    let row = &model.clips[clip];
    let channels = &model.channels[row.channel_first as usize..][..row.channel_count as usize];
    let mut times: Vec<f32> = channels
        .iter()
        .flat_map(|channel| &model.key_times[channel.time_first as usize..][..channel.key_count as usize])
        .copied()
        .collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    times
}

/// The spans of a stretch, at least one, in order, seconds. `keys` are the clip's [`key_times`].
pub(super) fn spans(clip: &ClipRow, keys: &[f32], stretch: usize) -> Vec<[f64; 2]> {
    let [begin, end] = ends(clip, stretch).map(|time| time.clamp(clip.start_seconds, clip.end_seconds));
    let after_begin = keys.partition_point(|key| *key <= begin);
    let until_end = keys.partition_point(|key| *key < end).max(after_begin);
    let mut times = vec![f64::from(begin)];
    times.extend(keys[after_begin..until_end].iter().copied().map(f64::from));
    times.push(end.into());
    let mut spans: Vec<[f64; 2]> = times.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    if begin < end && keys.get(until_end) == Some(&end) {
        spans.push([end.into(); 2]);
    }
    spans
}

/// The first and the last time of a stretch; of one that no time is in, twice some time.
fn ends(clip: &ClipRow, stretch: usize) -> [f32; 2] {
    let begin = first_from(clip, stretch).min(LAST_PLACE);
    // The least number is in the first stretch, so this is not it.
    let next = first_from(clip, stretch + 1);
    [number(begin), number((next - 1).max(begin))]
}

/// The place of the first number that is in this stretch or in a later one; one beyond the last place for none.
fn first_from(clip: &ClipRow, stretch: usize) -> u32 {
    let (mut from, mut until) = (0, LAST_PLACE + 1);
    while from < until {
        let middle = from + (until - from) / 2;
        if clip.stretch(number(middle)) < stretch {
            from = middle + 1;
        } else {
            until = middle;
        }
    }
    from
}

/// Place of zero among all `f32`, counted from `-∞`; both zeros are one number.
const ZERO_PLACE: u32 = f32::INFINITY.to_bits();

/// Place of `∞`.
const LAST_PLACE: u32 = 2 * ZERO_PLACE;

/// The number at a place.
fn number(place: u32) -> f32 {
    match place.checked_sub(ZERO_PLACE) {
        Some(above) => f32::from_bits(above),
        None => -f32::from_bits(ZERO_PLACE - place),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::rows::STRETCHES;

    fn clip(start_seconds: f32, end_seconds: f32) -> ClipRow {
        ClipRow {
            start_seconds,
            end_seconds,
            channel_first: 0,
            channel_count: 1,
        }
    }

    #[test]
    fn places_count_all_numbers_in_order() {
        for (place, expected) in [
            (0, f32::NEG_INFINITY),
            (1, f32::MIN),
            (ZERO_PLACE - 1, -f32::from_bits(1)),
            (ZERO_PLACE, 0.0),
            (ZERO_PLACE + 1, f32::from_bits(1)),
            (LAST_PLACE - 1, f32::MAX),
            (LAST_PLACE, f32::INFINITY),
        ] {
            assert_eq!(number(place), expected, "place {place}");
        }
    }

    /// Clips at whose borders `f32` rounds, with fewer numbers than stretches, and that cannot be divided.
    fn clips() -> [ClipRow; 8] {
        [
            clip(0.0, 1.0),
            clip(0.1, 0.8),
            clip(-7.3, 11.9),
            clip(1e6, 1e6 + 1.0),
            clip(0.0, 3e-44),
            clip(2.0, 2.0),
            clip(-3e38, 3e38),
            clip(0.0, 1e-40),
        ]
    }

    #[test]
    fn every_time_is_between_the_ends_of_its_stretch_alone() {
        for clip in clips() {
            let all: Vec<[f32; 2]> = (0..STRETCHES).map(|stretch| ends(&clip, stretch)).collect();
            let mut times = vec![f32::NEG_INFINITY, f32::MIN, f32::MAX, f32::INFINITY];
            for end in all.as_flattened() {
                times.extend([end.next_down(), *end, end.next_up()]);
            }
            for time in times {
                let stretch = clip.stretch(time);
                let [begin, end] = all[stretch];
                assert!(
                    begin <= time && time <= end,
                    "{clip:?}: {time} is in {stretch}, [{begin}, {end}]"
                );
            }
        }
    }

    #[test]
    fn spans_cover_a_stretch_and_have_no_key_inside() {
        for clip in clips() {
            let middle = 0.5 * clip.start_seconds + 0.5 * clip.end_seconds;
            let border = ends(&clip, 20)[0].clamp(clip.start_seconds, clip.end_seconds);
            let mut keys = vec![clip.start_seconds, middle, border.next_down(), border, clip.end_seconds];
            keys.retain(|key| (clip.start_seconds..=clip.end_seconds).contains(key));
            keys.sort_by(f32::total_cmp);
            keys.dedup();
            for stretch in 0..STRETCHES {
                let spans = spans(&clip, &keys, stretch);
                let [begin, end] =
                    ends(&clip, stretch).map(|time| f64::from(time.clamp(clip.start_seconds, clip.end_seconds)));
                assert_eq!((spans[0][0], spans[spans.len() - 1][1]), (begin, end), "{clip:?}");
                assert!(
                    spans.windows(2).all(|pair| pair[0][1] == pair[1][0]),
                    "{clip:?}: {spans:?}"
                );
                for [begin, end] in &spans {
                    let is_inside = |key: &f32| *begin < f64::from(*key) && f64::from(*key) < *end;
                    assert!(!keys.iter().any(is_inside), "{clip:?}: {spans:?}");
                }
                // What a channel jumps to at a key is where a span begins.
                let mut own = keys.iter().filter(|key| clip.stretch(**key) == stretch);
                let is_begun = |key: &f32| spans.iter().any(|span| span[0] == f64::from(*key));
                assert!(own.all(is_begun), "{clip:?}: {spans:?}");
            }
        }
    }
}
