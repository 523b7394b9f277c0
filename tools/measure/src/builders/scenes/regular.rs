use super::{Sink, Triangle};
use std::f64::consts::TAU;

/// Quads around the ring for one around the tube: as long as the tube is around, nearly, so quads are square.
const ASPECT: f64 = 2.5;

/// Fewest quads around the tube and the ring of a surface without folded triangles.
const FEWEST: usize = 3;

const RING_RADIUS: f64 = 2.0;
const TUBE_RADIUS: f64 = 0.8;

/// Waves that make the tube bumpy.
const WAVES: usize = 12;
/// Most periods of a wave around ring and tube.
const MOST_PERIODS: u32 = 40;

/// The tube's radius is multiplied by `1 + amplitude · sin(ring · u + tube · v + phase)`.
struct Wave {
    ring: f64,
    tube: f64,
    phase: f64,
    amplitude: f64,
}

/// A closed ring whose tube has bumps, row by row.
///
/// Where `wanted` is no grid's count, some triangles at the start are split in three; an odd one, which no closed surface
/// has, leaves a hole. Fewer than 18 triangles are a piece of the smallest ring.
pub(super) fn generate(wanted: usize, seed: u64, sink: &mut Sink) {
    let around_tube = ((wanted as f64 / 2.0 / ASPECT).sqrt() as usize).max(FEWEST);
    let around_ring = (wanted / (2 * around_tube)).max(FEWEST);
    let mut to_split = wanted.saturating_sub(2 * around_tube * around_ring).div_ceil(2);
    let waves = waves(seed);
    // Coordinates wrap, so that the seam is closed.
    let point = |row: usize, column: usize| {
        let turn = |index: usize, count: usize| TAU * (index % count) as f64 / count as f64;
        surface(&waves, turn(row, around_ring), turn(column, around_tube))
    };
    let mut add = |triangle: Triangle| {
        if to_split == 0 {
            return sink.add(triangle);
        }
        to_split -= 1;
        let [a, b, c] = triangle;
        let middle = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
        for pair in [[a, b], [b, c], [c, a]] {
            sink.add([pair[0], pair[1], middle]);
        }
    };
    for row in 0..around_ring {
        let mut left = [point(row, 0), point(row + 1, 0)];
        for column in 0..around_tube {
            let right = [point(row, column + 1), point(row + 1, column + 1)];
            add([left[0], left[1], right[1]]);
            add([left[0], right[1], right[0]]);
            left = right;
        }
    }
}

fn waves(seed: u64) -> [Wave; WAVES] {
    let mut random = fastrand::Rng::with_seed(seed);
    std::array::from_fn(|_| {
        let (ring, tube) = (random.u32(1..=MOST_PERIODS), random.u32(0..=MOST_PERIODS / 2));
        Wave {
            ring: f64::from(ring),
            tube: f64::from(tube),
            phase: TAU * random.f64(),
            // Steep enough to be seen, without folds.
            amplitude: 0.25 / f64::from(ring + tube),
        }
    })
}

fn surface(waves: &[Wave], u: f64, v: f64) -> [f32; 3] {
    let bumps: f64 = waves
        .iter()
        .map(|wave| wave.amplitude * libm::sin(wave.ring * u + wave.tube * v + wave.phase))
        .sum();
    let tube = TUBE_RADIUS * (1.0 + bumps);
    let out = RING_RADIUS + tube * libm::cos(v);
    [
        (out * libm::cos(u)) as f32,
        (tube * libm::sin(v)) as f32,
        (out * libm::sin(u)) as f32,
    ]
}
