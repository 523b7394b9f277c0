//! A line and what lies around it: the affine form of some relative motions.

use crate::poses::Chord;
use restpose_formats::{geom::round::f32_above, rows::BoneEnvelopeRow};

/// 2⁻⁴⁴: bounds the roundings in `f64` of the runtime's evaluation and of this one, relative to the numbers.
const ROUNDING: f64 = 1.0 / (1u64 << 44) as f64;

/// Steps of the power iteration. The line need not be the best, only a good one; it converges in a few.
const ITERATIONS: usize = 12;

/// The line is made longer by this factor, so that no end of a chord lies beyond its ends once it is rounded to `f32`.
const STRETCH: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;

/// An envelope's rows, one per bone, around all chords. `levers` are twelve lengths per bone: by how much each of its
/// numbers displaces vertices.
///
/// Guarantee: every pose of the chords and within their stray is inside as the runtime judges it, which takes the place on
/// the line that is nearest by these levers.
pub(crate) fn fit(chords: &[&Chord], levers: &[f64]) -> Vec<BoneEnvelopeRow> {
    let count = levers.len();
    let ends = || chords.iter().flat_map(|chord| [&chord.begin, &chord.end]);
    let (mut least, mut greatest) = (vec![f64::INFINITY; count], vec![f64::NEG_INFINITY; count]);
    for end in ends() {
        for n in 0..count {
            least[n] = least[n].min(end[n]);
            greatest[n] = greatest[n].max(end[n]);
        }
    }
    let mut center: Vec<f64> = (0..count).map(|n| 0.5 * (least[n] + greatest[n])).collect();

    // The main direction of the ends around the center, in lengths.
    let mut axis: Vec<f64> = (0..count).map(|n| (greatest[n] - least[n]) * levers[n]).collect();
    for _ in 0..ITERATIONS {
        let mut next = vec![0.0; count];
        for end in ends() {
            let along: f64 = (0..count).map(|n| (end[n] - center[n]) * levers[n] * axis[n]).sum();
            for n in 0..count {
                next[n] += along * (end[n] - center[n]) * levers[n];
            }
        }
        let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            break;
        }
        axis = next.iter().map(|x| x / length).collect();
    }
    let square: f64 = axis.iter().map(|x| x * x).sum();
    let mut direction = vec![0.0; count];
    if square > 0.0 && square.is_finite() {
        let place = |end: &[f64]| {
            (0..count)
                .map(|n| (end[n] - center[n]) * levers[n] * axis[n])
                .sum::<f64>()
                / square
        };
        let (first, last) = ends().fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), end| {
            let place = place(end);
            (first.min(place), last.max(place))
        });
        for n in (0..count).filter(|n| levers[*n] > 0.0) {
            let per_place = axis[n] / levers[n];
            direction[n] = 0.5 * (last - first) * per_place * STRETCH;
            center[n] += 0.5 * (first + last) * per_place;
        }
    }
    rows_around(chords, levers, &center, &direction)
}

/// The rows with this line, rounded, and the reach that holds all chords.
fn rows_around(chords: &[&Chord], levers: &[f64], center: &[f64], direction: &[f64]) -> Vec<BoneEnvelopeRow> {
    let count = levers.len();
    let rounded = |x: &f64| f64::from(*x as f32);
    let still = vec![0.0; count];
    let finite = direction.iter().all(|x| (*x as f32).is_finite());
    let direction = if finite { direction } else { &still };
    let center: Vec<f64> = center.iter().map(rounded).collect();
    let direction: Vec<f64> = direction.iter().map(rounded).collect();
    let square: f64 = (0..count)
        .map(|n| direction[n] * direction[n] * levers[n] * levers[n])
        .sum();
    let share: Vec<f64> = (0..count)
        .map(|n| {
            let share = direction[n] * levers[n] * levers[n] / square;
            if share.is_finite() { share } else { 0.0 }
        })
        .collect();
    let mut reach = vec![0.0f64; count];
    for chord in chords {
        // Strays and rounding move the place on the line, too.
        let wander: f64 = (0..count)
            .map(|n| {
                let size = chord.begin[n].abs().max(chord.end[n].abs()) + center[n].abs();
                share[n].abs() * (chord.stray[n] + ROUNDING * size)
            })
            .sum();
        for end in [&chord.begin, &chord.end] {
            let place: f64 = (0..count).map(|n| share[n] * (end[n] - center[n])).sum();
            // Where the place is cut off at an end of the line, places between the chord's ends bend by as much.
            let wander = wander + (place.abs() - 1.0).max(0.0);
            let place = place.clamp(-1.0, 1.0);
            for n in 0..count {
                let off = (end[n] - center[n] - place * direction[n]).abs();
                let size = end[n].abs() + center[n].abs() + direction[n].abs();
                let most = off + chord.stray[n] + wander * direction[n].abs() + ROUNDING * size;
                reach[n] = reach[n].max(most);
            }
        }
    }
    let row = |bone: usize| BoneEnvelopeRow {
        center: std::array::from_fn(|n| center[12 * bone + n] as f32),
        direction: std::array::from_fn(|n| direction[12 * bone + n] as f32),
        reach: std::array::from_fn(|n| f32_above(reach[12 * bone + n])),
    };
    (0..count / 12).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points near a skew line: the form follows it, and every chord is within reach at the place that is nearest.
    #[test]
    fn chords_near_a_line_have_a_small_reach() {
        let mut random = fastrand::Rng::with_seed(8);
        let line: Vec<f64> = (0..24).map(|_| random.f64() - 0.5).collect();
        let levers: Vec<f64> = (0..24).map(|n| if n == 5 { 0.0 } else { 0.1 + random.f64() }).collect();
        let mut point = |s: f64| -> Vec<f64> {
            let off = |random: &mut fastrand::Rng| 1e-3 * (random.f64() - 0.5);
            line.iter().map(|x| 3.0 + s * x + off(&mut random)).collect()
        };
        let chords: Vec<Chord> = (0..40)
            .map(|step| Chord {
                begin: point(f64::from(step) / 40.0),
                end: point(f64::from(step + 1) / 40.0),
                stray: vec![1e-5; 24],
            })
            .collect();
        let rows = fit(&chords.iter().collect::<Vec<_>>(), &levers);
        assert_eq!(rows.len(), 2);
        for (bone, row) in rows.iter().enumerate() {
            for n in (0..12).filter(|n| levers[12 * bone + n] > 0.0) {
                assert!(row.reach[n] < 3e-3, "{n}: {}", row.reach[n]);
                assert!((f64::from(row.direction[n]).abs() - 0.5 * line[12 * bone + n].abs()).abs() < 3e-3);
            }
        }
    }

    #[test]
    fn one_pose_is_a_point() {
        let chord = Chord {
            begin: vec![0.25; 12],
            end: vec![0.25; 12],
            stray: vec![0.0; 12],
        };
        let [row] = fit(&[&chord], &[1.0; 12])[..] else {
            panic!("one bone")
        };
        assert_eq!((row.center, row.direction), ([0.25; 12], [0.0; 12]));
        assert!(row.reach.iter().all(|reach| *reach < 1e-12));
    }
}
