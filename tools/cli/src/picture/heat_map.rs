use super::colour::{Colour, decode};

/// Colours of the ramp from no work to the most, evenly spaced: brightness rises all the way, so it reads in grey too.
const STOPS: [[u8; 3]; 7] = [
    [8, 10, 34],
    [52, 24, 102],
    [120, 32, 118],
    [190, 52, 92],
    [236, 100, 50],
    [250, 172, 56],
    [252, 244, 196],
];

/// The colour of a share of the most work, 0 to 1; clamped.
pub fn heat(share: f32) -> Colour {
    let last = STOPS.len() - 1;
    let place = share.clamp(0.0, 1.0) * last as f32;
    let below = (place as usize).min(last - 1);
    let mix = |k: usize| {
        let (a, b) = (f32::from(STOPS[below][k]), f32::from(STOPS[below + 1][k]));
        a + (b - a) * (place - below as f32)
    };
    decode([0, 1, 2].map(|k| (mix(k) + 0.5) as u8))
}

/// The end of a scale that shows all but the hottest `1 / ignored` of `counts`: a round number, 1, 2 or 5 times a
/// power of ten, at least 10.
pub fn scale_end(mut counts: Vec<u32>, ignored: usize) -> u32 {
    counts.sort_unstable();
    let place = counts.len().saturating_sub(1 + counts.len() / ignored);
    let reached = counts.get(place).copied().unwrap_or(0);
    (1..9)
        .flat_map(|power| [1, 2, 5].map(|first| first * 10u32.pow(power)))
        .find(|round| *round >= reached)
        .unwrap_or(1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_runs_from_its_first_stop_to_its_last_and_grows_brighter() {
        assert_eq!(heat(-1.0), decode(STOPS[0]));
        assert_eq!(heat(7.0), decode(STOPS[6]));
        let brightness = |i: u8| heat(f32::from(i) / 255.0).dot(Colour::new(0.21, 0.72, 0.07));
        assert!((1..=255).all(|i| brightness(i) >= brightness(i - 1)));
    }

    #[test]
    fn a_scale_ends_at_a_round_number_and_ignores_outliers() {
        assert_eq!(scale_end(vec![], 100), 10);
        assert_eq!(scale_end(vec![11], 100), 20);
        assert_eq!(scale_end(vec![50; 10], 100), 50);
        let mut counts = vec![30; 1000];
        counts.extend([100_000; 5]);
        assert_eq!(scale_end(counts, 100), 50);
        assert_eq!(scale_end(vec![u32::MAX], 100), 1_000_000_000);
    }
}
