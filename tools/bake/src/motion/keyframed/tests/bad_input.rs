use super::{
    super::{DecomposeSettings, TrackKind},
    known_motion::decompose,
    soup::{Soup, path},
};
use glam::{DAffine3, DMat3, DVec3};

fn grid(side: u32, place: impl Fn(usize, f64, f64) -> DVec3, keys: usize) -> Soup {
    let frame = |key| {
        let points = (0..side * side).map(|p| (f64::from(p % side), f64::from(p / side)));
        points.map(|(x, y)| place(key, x, y).as_vec3().to_array()).collect()
    };
    let corner = |p: u32| [[p, p + 1, p + side], [p + 1, p + side + 1, p + side]];
    Soup {
        frames: (0..keys).map(frame).collect(),
        triangles: (0..side * (side - 1))
            .filter(|p| p % side != side - 1)
            .flat_map(corner)
            .collect(),
    }
}

/// A wave on a plane, in some unit at some offset.
fn wave(side: u32, unit: f64, offset: f64, keys: usize) -> Soup {
    let place = |key: usize, x: f64, y: f64| {
        DVec3::new(x, y, (x * 0.8 + key as f64).sin() * y * 0.2) * unit + DVec3::splat(offset)
    };
    grid(side, place, keys)
}

#[test]
fn units_and_offsets_do_not_matter() {
    let expected = decompose(&wave(12, 1.0, 0.0, 9), &DecomposeSettings::default());
    assert!(expected.clusters.len() > 2);
    for (unit, offset) in [(1e-20, 0.0), (1e20, 0.0), (1e29, 0.0), (1.0, 100.0), (1e20, 1e22)] {
        let out = decompose(&wave(12, unit, offset, 9), &DecomposeSettings::default());
        let ratio = out.report.cost / out.report.ideal_cost / (expected.report.cost / expected.report.ideal_cost);
        // Coordinates are rounded to f32, which may lead the relaxation elsewhere.
        assert!((0.8..1.25).contains(&ratio), "unit {unit}, offset {offset}: {ratio}");
    }
}

#[test]
fn meshes_without_extent_decompose() {
    let places: [fn(usize, f64, f64) -> DVec3; 6] = [
        |_, _, _| DVec3::ONE,
        |key, _, _| DVec3::X * key as f64,
        |key, x, y| DVec3::X * (x + y * 0.5 + (key as f64 + x * y).sin()),
        |key, x, _| DVec3::new(x, key as f64 * x, 0.0),
        |key, x, y| {
            if key == 2 {
                DVec3::ZERO
            } else {
                DVec3::new(x, y, (x * y + key as f64).sin())
            }
        },
        |key, x, y| DVec3::new(x, y, (x * y).sin()) * if key % 2 == 0 { 1.0 } else { 1e-7 },
    ];
    for (case, place) in places.iter().enumerate() {
        for keys in [1, 2, 5] {
            let out = decompose(&grid(5, place, keys), &DecomposeSettings::default());
            if keys == 1 {
                assert!(
                    out.clusters.iter().all(|cluster| cluster.kind == TrackKind::Static),
                    "case {case}"
                );
            }
        }
    }
}

#[test]
fn teleports_flips_and_mirrors_keep_every_frame_usable() {
    let flip = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)));
    let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
    let away = DAffine3::from_translation(DVec3::splat(1e6));
    let crushed = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1e-9)));
    for seed in 0..4 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut soup = Soup::default();
        let motion = [DAffine3::IDENTITY, flip, away, mirror, crushed, DAffine3::IDENTITY];
        soup.add_strip(&mut random, 50, DVec3::ZERO, 1.0, &motion, 0.01);
        decompose(&soup, &DecomposeSettings::default());
    }
}

#[test]
fn noise_decomposes() {
    let mut random = fastrand::Rng::with_seed(5);
    for round in 0..40 {
        let (points, keys, count) = (random.usize(1..30), random.usize(1..12), random.usize(1..40));
        let scale = [1.0, 1e-20, 1e20, 1e30][round % 4];
        let mut coordinate = || (random.f64() * 2.0 - 1.0) * scale;
        let frames = (0..keys)
            .map(|_| {
                (0..points)
                    .map(|_| std::array::from_fn(|_| coordinate() as f32))
                    .collect()
            })
            .collect();
        let triangles = (0..count)
            .map(|_| std::array::from_fn(|_| random.u32(0..points as u32)))
            .collect();
        for max_clusters in [1, 2, 25] {
            let settings = DecomposeSettings {
                max_clusters,
                ..DecomposeSettings::default()
            };
            decompose(
                &Soup {
                    frames: Vec::clone(&frames),
                    triangles: Vec::clone(&triangles),
                },
                &settings,
            );
        }
    }
}

#[test]
fn a_hundred_thousand_keys_take_a_moment() {
    let mut random = fastrand::Rng::with_seed(9);
    let motion = path(&mut random, 100_000, 1.2);
    let mut one = Soup::default();
    one.add_strip(&mut random, 1, DVec3::ZERO, 1.0, &motion, 0.3);
    let out = decompose(&one, &DecomposeSettings::default());
    assert_eq!(out.clusters.len(), 1);
    // Three clusters of more triangles, for which every key has a place in the relaxation.
    let motion = path(&mut random, 2_000, 1.2);
    let mut few = Soup::default();
    few.add_strip(&mut random, 6, DVec3::ZERO, 1.0, &motion, 0.3);
    let settings = DecomposeSettings {
        max_clusters: 3,
        ..DecomposeSettings::default()
    };
    decompose(&few, &settings);
}

#[test]
fn no_triangles_no_clusters() {
    let soup = Soup {
        frames: vec![vec![[0.0; 3]; 3]; 4],
        triangles: Vec::new(),
    };
    assert!(decompose(&soup, &DecomposeSettings::default()).clusters.is_empty());
}
