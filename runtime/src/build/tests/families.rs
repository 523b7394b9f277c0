use super::random::Random;
use restpose_formats::geom::Aabb;

/// Makes any number of boxes from a seed.
type Family = fn(usize, u64) -> Vec<Aabb>;

/// Kinds of box sets; each yields the same boxes for the same seed.
pub(super) const FAMILIES: [(&str, Family); 18] = [
    ("small", |n, seed| scattered(n, seed, 100.0, 4.0)),
    ("overlapping", |n, seed| scattered(n, seed, 10.0, 10.0)),
    ("grid", grid),
    ("identical", |n, _| {
        vec![
            Aabb {
                min: [1.0, 2.0, 3.0],
                max: [2.0, 4.0, 6.0]
            };
            n
        ]
    }),
    ("identical_points", |n, _| {
        vec![
            Aabb {
                min: [5.0; 3],
                max: [5.0; 3]
            };
            n
        ]
    }),
    ("nested", nested),
    ("sorted", sorted),
    ("stairs", stairs),
    ("exponential", exponential),
    ("planar", planar),
    ("walls", walls),
    ("points", |n, seed| scattered(n, seed, 3.0, 0.0)),
    ("line", line),
    ("huge", |n, seed| scattered(n, seed, 1e30, 3e29)),
    ("tiny", |n, seed| scattered(n, seed, 1e-30, 1e-31)),
    ("largest_and_smallest", largest_and_smallest),
    ("teapot_in_stadium", teapot_in_stadium),
    ("unusable", unusable),
];

fn scattered(n: usize, seed: u64, half: f32, size: f32) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| {
            let min = [0; 3].map(|_| random.within(half));
            Aabb {
                min,
                max: min.map(|x| x + random.unit() * size),
            }
        })
        .collect()
}

/// Corners on a small integer grid: most positions are shared, many boxes planar.
fn grid(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| {
            let min = [0; 3].map(|_| random.below(5) as f32);
            Aabb {
                min,
                max: min.map(|x| x + random.below(3) as f32),
            }
        })
        .collect()
}

fn nested(n: usize, _: u64) -> Vec<Aabb> {
    (1..=n)
        .map(|i| Aabb {
            min: [-(i as f32); 3],
            max: [i as f32; 3],
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

/// All begin together and end apart in a long thin cell: each plane is straddled by all boxes behind it.
fn stairs(n: usize, _: u64) -> Vec<Aabb> {
    (0..n)
        .map(|i| Aabb {
            min: [0.0; 3],
            max: [(i + 1) as f32, 1e-3, 1e-3],
        })
        .collect()
}

fn exponential(n: usize, _: u64) -> Vec<Aabb> {
    (0..n)
        .map(|i| f32::exp2(i as f32 - 32.0))
        .map(|x| Aabb {
            min: [x; 3],
            max: [1.5 * x; 3],
        })
        .collect()
}

/// Flat along one axis each, on few different planes.
fn planar(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| {
            let axis = random.below(3);
            let mut min = [0; 3].map(|_| random.within(10.0));
            let mut max = min.map(|x| x + random.unit() * 3.0);
            min[axis] = random.below(4) as f32;
            max[axis] = min[axis];
            Aabb { min, max }
        })
        .collect()
}

/// A room: tiles on its six walls, which are the bounds, and small things inside.
fn walls(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|i| {
            let mut min = [0; 3].map(|_| random.below(8) as f32);
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
    let mut random = Random::new(seed);
    (0..n)
        .map(|_| (random.within(5.0), random.unit()))
        .map(|(y, length)| Aabb {
            min: [1.0, y, 2.0],
            max: [1.0, y + length, 2.0],
        })
        .collect()
}

/// Sides anywhere in the range of numbers, subnormal ones too.
fn largest_and_smallest(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    let mut side = || {
        let magnitude = [f32::MAX, 1e30, 1.0, 1e-30, f32::MIN_POSITIVE, 1e-45, 0.0][random.below(7)];
        if random.below(2) == 0 { magnitude } else { -magnitude }
    };
    (0..n)
        .map(|_| {
            let (a, b) = ([0; 3].map(|_| side()), [0; 3].map(|_| side()));
            Aabb::around([a, b])
        })
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

/// Empty, infinite and NaN sides among good ones.
fn unusable(n: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random::new(seed);
    let mut boxes = scattered(n, seed, 10.0, 3.0);
    for bounds in &mut boxes {
        let axis = random.below(3);
        match random.below(8) {
            0 => *bounds = Aabb::EMPTY,
            1 => std::mem::swap(&mut bounds.min[axis], &mut bounds.max[axis]),
            2 => bounds.max[axis] = f32::INFINITY,
            3 => bounds.min[axis] = f32::NEG_INFINITY,
            4 => bounds.min[axis] = f32::NAN,
            5 => bounds.max[axis] = f32::NAN,
            _ => {}
        }
    }
    boxes
}
