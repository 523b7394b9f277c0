use super::Sink;
use fastrand::Rng;
use std::f64::consts::{PI, TAU};

/// Sides of the floor.
const ROOM: f64 = 30.0;
const WALL_HEIGHT: f64 = 6.0;

/// A piece of furniture stands for the square root of this many triangles of the scene.
const TRIANGLES_PER_PIECE_SQUARED: f64 = 64.0;

/// Knobs of a piece.
const KNOBS: usize = 6;

/// Blades of a piece: long thin triangles across it.
const BLADES: usize = 10;

/// A stage: a floor and two walls, so that a camera from the front right sees what is inside. On it rows of tables, each
/// turned its own way, of boxes, blades and knobs. Knobs get what triangles are left, some pieces a hundred times more than
/// others; the last one takes all that is missing.
pub(super) fn generate(wanted: usize, seed: u64, sink: &mut Sink) {
    let mut random = Rng::with_seed(seed);
    room(sink);
    let pieces = ((wanted as f64 / TRIANGLES_PER_PIECE_SQUARED).sqrt().ceil() as usize).max(1);
    let shares: Vec<f64> = (0..pieces).map(|_| 1e-2f64.powf(random.f64())).collect();
    let mut shares_left: f64 = shares.iter().sum();
    let columns = (pieces as f64).sqrt().ceil() as usize;
    let spacing = ROOM / (columns as f64 + 1.0);
    for (piece, share) in shares.iter().enumerate() {
        let place = |index: usize| spacing * (index as f64 + 1.0) - 0.5 * ROOM;
        let placed = Placed::new(
            [place(piece % columns), place(piece / columns)],
            0.9 * spacing,
            &mut random,
        );
        let last = piece + 1 == pieces;
        let budget = if last {
            sink.left()
        } else {
            (sink.left() as f64 * share / shares_left) as usize
        };
        shares_left -= share;
        furniture(&placed, budget, last, &mut random, sink);
    }
}

fn room(sink: &mut Sink) {
    let (h, top) = ((0.5 * ROOM) as f32, WALL_HEIGHT as f32);
    let [a, b, c, d] = [[-h, 0.0, -h], [h, 0.0, -h], [h, 0.0, h], [-h, 0.0, h]];
    let up = |p: [f32; 3]| [p[0], top, p[2]];
    sink.quad([a, d, c, b]);
    sink.quad([a, b, up(b), up(a)]);
    sink.quad([d, a, up(a), up(d)]);
}

/// Where a piece of furniture stands.
struct Placed {
    at: [f64; 2],
    size: f64,
    /// Cosine and sine of how far it is turned.
    turn: [f64; 2],
}

impl Placed {
    /// Every other one stands along the walls.
    fn new(at: [f64; 2], size: f64, random: &mut Rng) -> Self {
        let angle = if random.bool() { 0.0 } else { TAU * random.f64() };
        Self {
            at,
            size,
            turn: [libm::cos(angle), libm::sin(angle)],
        }
    }

    /// A point of the piece, −0.5 to 0.5 sideways and 0 to 1 upwards, in the room.
    fn point(&self, [x, y, z]: [f64; 3]) -> [f32; 3] {
        let [c, s] = self.turn;
        let (x, y, z) = (0.7 * self.size * x, 0.4 * self.size * y, 0.7 * self.size * z);
        [
            (self.at[0] + c * x + s * z) as f32,
            y as f32,
            (self.at[1] - s * x + c * z) as f32,
        ]
    }
}

fn furniture(placed: &Placed, budget: usize, last: bool, random: &mut Rng, sink: &mut Sink) {
    let before = sink.left();
    solid(placed, [-0.5, 0.92, -0.5], [0.5, 1.0, 0.5], sink);
    for [x, z] in [[-0.45, -0.45], [0.42, -0.45], [-0.45, 0.42], [0.42, 0.42]] {
        solid(placed, [x, 0.0, z], [x + 0.03, 0.92, z + 0.03], sink);
    }
    for blade in 0..BLADES {
        let y = 0.1 + 0.08 * blade as f64;
        let [from, to] = [-0.45, 0.45].map(|x| x + 0.02 * random.f64());
        sink.quad(
            [
                [from, y, -0.44],
                [to, y + 0.004, 0.44],
                [to, y + 0.01, 0.44],
                [from, y + 0.006, -0.44],
            ]
            .map(|p| placed.point(p)),
        );
    }
    let left = budget.saturating_sub(before - sink.left());
    for number in 0..KNOBS {
        let center = [random.f64() - 0.5, 1.02, random.f64() - 0.5];
        let radius = 0.004 + 0.02 * random.f64();
        let triangles = if last && number + 1 == KNOBS {
            sink.left()
        } else {
            left / KNOBS
        };
        knob(placed, center, radius, triangles, sink);
    }
}

/// A box.
fn solid(placed: &Placed, min: [f64; 3], max: [f64; 3], sink: &mut Sink) {
    let corner = |index: usize| {
        placed.point(std::array::from_fn(
            |k| if index >> k & 1 == 0 { min[k] } else { max[k] },
        ))
    };
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        sink.quad(face.map(corner));
    }
}

/// A ball of exactly so many triangles, slender at its poles; where the last row is not full it has a gap.
fn knob(placed: &Placed, center: [f64; 3], radius: f64, triangles: usize, sink: &mut Sink) {
    let around = ((triangles as f64 / 2.0).sqrt() as usize).max(3);
    let rows = triangles.div_ceil(2 * around);
    let point = |row: usize, column: usize| {
        let down = PI * (row as f64 + 0.5) / (rows as f64 + 1.0);
        let turn = TAU * (column % around) as f64 / around as f64;
        let [y, flat] = [libm::cos(down), libm::sin(down)];
        placed.point([
            center[0] + radius * flat * libm::cos(turn),
            center[1] + radius * y,
            center[2] + radius * flat * libm::sin(turn),
        ])
    };
    let stop = sink.left().saturating_sub(triangles);
    for row in 0..rows {
        let mut left = [point(row, 0), point(row + 1, 0)];
        for column in 1..=around {
            let right = [point(row, column), point(row + 1, column)];
            for triangle in [[left[0], left[1], right[1]], [left[0], right[1], right[0]]] {
                if sink.left() > stop {
                    sink.add(triangle);
                }
            }
            left = right;
        }
    }
}
