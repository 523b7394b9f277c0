use fastrand::Rng;
use restpose_formats::geom::Aabb;

/// Makes any number of boxes from a seed.
type Family = fn(usize, u64) -> Vec<Aabb>;

/// Kinds of box sets that builders must end on; each yields the same boxes for the same seed.
pub(crate) const FAMILIES: [(&str, Family); 20] = [
    ("small", |n, seed| scattered(n, seed, 100.0, 4.0)),
    ("overlapping", |n, seed| scattered(n, seed, 10.0, 10.0)),
    ("points", |n, seed| scattered(n, seed, 3.0, 0.0)),
    ("huge", |n, seed| scattered(n, seed, 1e30, 3e29)),
    ("tiny", |n, seed| scattered(n, seed, 1e-30, 1e-31)),
    ("subnormal", |n, seed| scattered(n, seed, 1e-43, 1e-44)),
    ("largest", |n, seed| scattered(n, seed, f32::MAX, 0.0)),
    ("grid", grid),
    ("identical", |n, _| vec![cube(1.0, 2.0); n]),
    ("identical_points", |n, _| vec![cube(5.0, 5.0); n]),
    ("nested", |n, _| (1..=n).map(|i| cube(-(i as f32), i as f32)).collect()),
    ("sorted", sorted),
    ("shuffled", shuffled),
    ("stairs", stairs),
    ("exponential", exponential),
    ("planar", planar),
    ("walls", walls),
    ("line", line),
    ("largest_and_smallest", largest_and_smallest),
    ("teapot_in_stadium", teapot_in_stadium),
];

fn cube(min: f32, max: f32) -> Aabb {
    Aabb {
        min: [min; 3],
        max: [max; 3],
    }
}

/// Uniform in −`half` to `half`.
fn within(random: &mut Rng, half: f32) -> f32 {
    (2.0 * random.f32() - 1.0) * half
}

pub(crate) fn scattered(n: usize, seed: u64, half: f32, size: f32) -> Vec<Aabb> {
    let mut random = Rng::with_seed(seed);
    (0..n)
        .map(|_| {
            let min = [0; 3].map(|_| within(&mut random, half));
            Aabb {
                min,
                max: min.map(|x| x + random.f32() * size),
            }
        })
        .collect()
}

/// Corners on a small integer grid, with both zeros: most positions are shared, many boxes planar.
fn grid(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Rng::with_seed(seed);
    (0..n)
        .map(|_| {
            let min = [0; 3].map(|_| [-2.0, -1.0, -0.0, 0.0, 1.0][random.usize(..5)]);
            Aabb {
                min,
                max: min.map(|x: f32| x + [-0.0, 1.0, 2.0][random.usize(..3)]),
            }
        })
        .collect()
}

fn sorted(n: usize, _: u64) -> Vec<Aabb> {
    (0..n)
        .map(|i| Aabb {
            min: [i as f32, 0.0, 0.0],
            max: [i as f32 + 1.0, 1.0, 1.0],
        })
        .collect()
}

fn shuffled(n: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = sorted(n, seed);
    Rng::with_seed(seed).shuffle(&mut boxes);
    boxes
}

/// All begin together and end apart.
fn stairs(n: usize, _: u64) -> Vec<Aabb> {
    (0..n)
        .map(|i| Aabb {
            min: [0.0; 3],
            max: [(i + 1) as f32, 1e-3, 1e-3],
        })
        .collect()
}

/// Over the whole range of exponents and round again: each median cuts off the largest only.
pub(crate) fn exponential(n: usize, _: u64) -> Vec<Aabb> {
    (0..n)
        .map(|i| f32::exp2((i % 250) as f32 - 124.0))
        .map(|x| cube(x, 1.5 * x))
        .collect()
}

/// Flat along one axis each, on few different planes.
fn planar(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Rng::with_seed(seed);
    let mut boxes = scattered(n, seed, 10.0, 3.0);
    for bounds in &mut boxes {
        let axis = random.usize(..3);
        bounds.min[axis] = random.u8(..4).into();
        bounds.max[axis] = bounds.min[axis];
    }
    boxes
}

/// A room: tiles on its six walls, which are the bounds, and small things inside.
fn walls(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Rng::with_seed(seed);
    (0..n)
        .map(|i| {
            let mut min = [0; 3].map(|_| f32::from(random.u8(..8)));
            let mut max = min.map(|x| x + 1.0);
            match i % 7 {
                6 => max = min.map(|x| x + 0.5),
                wall => {
                    min[wall / 2] = 8.0 * (wall % 2) as f32;
                    max[wall / 2] = min[wall / 2];
                }
            }
            Aabb { min, max }
        })
        .collect()
}

/// Boxes without area along one line.
fn line(n: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = scattered(n, seed, 5.0, 1.0);
    for bounds in &mut boxes {
        for (axis, side) in [(0, 1.0), (2, 2.0)] {
            (bounds.min[axis], bounds.max[axis]) = (side, side);
        }
    }
    boxes
}

/// Sides anywhere in the range of numbers, subnormal ones too.
fn largest_and_smallest(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Rng::with_seed(seed);
    let mut side = || {
        let magnitude = [f32::MAX, 1e30, 1.0, 1e-30, f32::MIN_POSITIVE, 1e-45, 0.0][random.usize(..7)];
        if random.bool() { magnitude } else { -magnitude }
    };
    (0..n)
        .map(|_| {
            let (a, b) = ([0; 3].map(|_| side()), [0; 3].map(|_| side()));
            Aabb::around([a, b])
        })
        .collect()
}

/// One giant among many tiny ones.
fn teapot_in_stadium(n: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = scattered(n, seed, 1e-3, 1e-4);
    if let Some(first) = boxes.first_mut() {
        *first = Aabb {
            min: [-1e6; 3],
            max: [1e6, 1e6, 1e6 / 4.0],
        };
    }
    boxes
}
