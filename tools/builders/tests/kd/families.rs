use restpose_runtime::Aabb;

/// Makes any number of boxes from a seed.
pub type Family = fn(usize, u64) -> Vec<Aabb>;

/// Kinds of usable box sets; each yields the same boxes for the same seed.
pub const FAMILIES: [(&str, Family); 15] = [
    ("small", |n, seed| scattered(n, seed, 100.0, 4.0)),
    ("overlapping", |n, seed| scattered(n, seed, 10.0, 10.0)),
    ("grid", grid),
    ("identical", |n, _| vec![cube(1.0, 2.0); n]),
    ("identical_points", |n, _| vec![cube(5.0, 5.0); n]),
    ("nested", |n, _| (1..=n).map(|i| cube(-(i as f32), i as f32)).collect()),
    ("stairs", stairs),
    ("exponential", exponential),
    ("walls", walls),
    ("points", |n, seed| scattered(n, seed, 3.0, 0.0)),
    ("line", line),
    ("huge", |n, seed| scattered(n, seed, 1e30, 3e29)),
    ("tiny", |n, seed| scattered(n, seed, 1e-30, 1e-31)),
    ("largest_and_smallest", largest_and_smallest),
    ("teapot_in_stadium", teapot_in_stadium),
];

fn cube(min: f32, max: f32) -> Aabb {
    Aabb {
        min: [min; 3],
        max: [max; 3],
    }
}

pub fn scattered(n: usize, seed: u64, half: f32, size: f32) -> Vec<Aabb> {
    let mut random = fastrand::Rng::with_seed(seed);
    let boxes = (0..n).map(|_| {
        let min = [0; 3].map(|_| (2.0 * random.f32() - 1.0) * half);
        Aabb {
            min,
            max: min.map(|x| x + random.f32() * size),
        }
    });
    boxes.collect()
}

/// Corners on a small integer grid: most positions are shared, many boxes planar.
fn grid(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = fastrand::Rng::with_seed(seed);
    let boxes = (0..n).map(|_| {
        let min = [0; 3].map(|_| random.u32(0..5) as f32);
        Aabb {
            min,
            max: min.map(|x| x + random.u32(0..3) as f32),
        }
    });
    boxes.collect()
}

/// All begin together and end apart in a long thin cell: each plane is straddled by all boxes behind it.
fn stairs(n: usize, _: u64) -> Vec<Aabb> {
    let boxes = (1..=n).map(|i| Aabb {
        min: [0.0; 3],
        max: [i as f32, 1e-3, 1e-3],
    });
    boxes.collect()
}

fn exponential(n: usize, _: u64) -> Vec<Aabb> {
    let sides = (0..n).map(|i| f32::exp2((i % 200) as f32 - 120.0));
    sides.map(|x| cube(x, 1.5 * x)).collect()
}

/// A room: tiles on its six walls, which are the bounds, and small things inside.
fn walls(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = fastrand::Rng::with_seed(seed);
    let boxes = (0..n).map(|i| {
        let mut min = [0; 3].map(|_| random.u32(0..8) as f32);
        let mut max = min.map(|x| x + 1.0);
        match i % 7 {
            6 => max = min.map(|x| x + 0.5),
            wall => {
                min[wall / 2] = 8.0 * (wall % 2) as f32;
                max[wall / 2] = min[wall / 2];
            }
        }
        Aabb { min, max }
    });
    boxes.collect()
}

/// Boxes without area along one line.
fn line(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = fastrand::Rng::with_seed(seed);
    let boxes = (0..n).map(|_| {
        let (y, length) = (random.f32() * 10.0 - 5.0, random.f32());
        Aabb {
            min: [1.0, y, 2.0],
            max: [1.0, y + length, 2.0],
        }
    });
    boxes.collect()
}

/// Sides anywhere in the range of numbers, subnormal ones too.
fn largest_and_smallest(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut side = || {
        let magnitude = [f32::MAX, 1e30, 1.0, 1e-30, f32::MIN_POSITIVE, 1e-45, 0.0][random.usize(0..7)];
        if random.bool() { magnitude } else { -magnitude }
    };
    (0..n)
        .map(|_| Aabb::around([[0; 3].map(|_| side()), [0; 3].map(|_| side())]))
        .collect()
}

fn teapot_in_stadium(n: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = scattered(n, seed, 1e-3, 1e-4);
    if let Some(first) = boxes.first_mut() {
        *first = Aabb {
            min: [-1e6; 3],
            max: [1e6, 1e6, -1e6],
        };
    }
    boxes
}

/// Things in a room, each of a thousand boxes that are small beside those of its walls.
pub fn furnished() -> Vec<Aabb> {
    let mut out = walls(1000, 1);
    for (piece, place) in scattered(20, 2, 3.0, 0.0).into_iter().enumerate() {
        out.extend(scattered(1000, piece as u64, 0.01, 1e-3).into_iter().map(|small| Aabb {
            min: std::array::from_fn(|k| small.min[k] + place.min[k] + 4.0),
            max: std::array::from_fn(|k| small.max[k] + place.min[k] + 4.0),
        }));
    }
    out
}
