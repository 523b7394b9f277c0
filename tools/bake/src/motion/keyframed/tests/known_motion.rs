use super::{
    super::{DecomposeSettings, Decomposition, TrackKind, decompose_keys},
    soup::{Soup, path},
};
use crate::NoProgress;
use glam::{DAffine3, DVec3};
use restpose_runtime::invert_frame;

pub(super) fn decompose(soup: &Soup, settings: &DecomposeSettings) -> Decomposition {
    let out = decompose_keys(&soup.keys(), settings, &NoProgress);
    check(soup, settings, &out);
    out
}

/// What every decomposition guarantees.
fn check(soup: &Soup, settings: &DecomposeSettings, out: &Decomposition) {
    assert_eq!(out.cluster_of.len(), soup.triangles.len());
    assert!(
        out.clusters.len() <= settings.max_clusters.max(1),
        "{} clusters",
        out.clusters.len()
    );
    let mut used = vec![false; out.clusters.len()];
    for cluster in &out.cluster_of {
        used[*cluster as usize] = true;
    }
    assert!(used.iter().all(|used| *used), "a cluster without triangles");
    assert!(out.rest_key < soup.frames.len());
    for cluster in &out.clusters {
        assert_eq!(cluster.from_local.len(), soup.frames.len());
        for frame in &cluster.from_local {
            assert!(invert_frame(frame).is_some(), "{frame:?}");
            let [x, y, z] = [0, 1, 2].map(|k| DVec3::from_array(frame.columns[k].map(f64::from)));
            assert!(x.cross(y).dot(z) > 0.0, "mirrored: {frame:?}");
        }
    }
}

/// Greatest distance of a fuzzy position from that in the rest key, over all triangles of coherent clusters.
fn greatest_residual(soup: &Soup, out: &Decomposition) -> f64 {
    let mut greatest = 0.0f64;
    for (triangle, cluster) in soup.triangles.iter().zip(&out.cluster_of) {
        let track = &out.clusters[*cluster as usize].from_local;
        let local = |key: usize, point: u32| {
            let rows = invert_frame(&track[key]).unwrap();
            let v: [f64; 3] = std::array::from_fn(|k| {
                f64::from(soup.frames[key][point as usize][k]) - f64::from(track[key].columns[3][k])
            });
            DVec3::from_array(rows.map(|row| DVec3::from_array(row).dot(DVec3::from_array(v))))
        };
        for point in triangle {
            let rest = local(out.rest_key, *point);
            for key in 0..soup.frames.len() {
                greatest = greatest.max((local(key, *point) - rest).length());
            }
        }
    }
    greatest
}

#[test]
fn pieces_with_their_own_affine_motion_are_rigid_and_told_apart() {
    for seed in 0..8 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut soup = Soup::default();
        let mut expected = Vec::new();
        for piece in 0..5 {
            let stretch = if piece % 2 == 0 { 1.0 } else { 1.5 };
            let motion = path(&mut random, 12, stretch);
            soup.add_strip(&mut random, 40, DVec3::splat(f64::from(piece)), 1.0, &motion, 0.0);
            expected.extend([piece; 40]);
        }
        let still = vec![DAffine3::IDENTITY; 12];
        soup.add_strip(&mut random, 10, DVec3::ZERO, 1.0, &still, 0.0);
        let out = decompose(&soup, &DecomposeSettings::default());
        assert_eq!(out.clusters.len(), 6, "seed {seed}");
        assert_eq!(out.clusters[0].kind, TrackKind::Static);
        assert!(out.clusters[1..].iter().all(|cluster| cluster.kind == TrackKind::Rigid));
        assert!(out.cluster_of[200..].iter().all(|cluster| *cluster == 0));
        for (a, b) in [(0, 39), (40, 79), (0, 40), (80, 120), (120, 160), (160, 199)] {
            assert_eq!(
                out.cluster_of[a] == out.cluster_of[b],
                expected[a] == expected[b],
                "seed {seed}, {a} {b}"
            );
        }
        // Coordinates up to ten, f32.
        let residual = greatest_residual(&soup, &out);
        assert!(residual < 1e-5, "seed {seed}: {residual}");
    }
}

#[test]
fn joined_limbs_are_told_apart() {
    for seed in 0..8 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut soup = Soup::default();
        for piece in 0..4 {
            let motion = path(&mut random, 10, 1.3);
            soup.add_strip(&mut random, 60, DVec3::X * f64::from(piece) * 3.0, 1.0, &motion, 0.0);
        }
        // A needle between each two makes one component of all; it belongs to no limb.
        for joint in 0..3u32 {
            let first = joint * 62;
            soup.triangles.push([first + 61, first + 61, first + 62]);
        }
        let settings = DecomposeSettings {
            max_clusters: 8,
            ..DecomposeSettings::default()
        };
        let out = decompose(&soup, &settings);
        assert_eq!(out.report.rigid_triangles, 0);
        // A limb may be split, where its parts fit other axes better; no cluster may hold two.
        for cluster in 0..out.clusters.len() as u32 {
            let mut limbs: Vec<usize> = (0..240)
                .filter(|t| out.cluster_of[*t] == cluster)
                .map(|t| t / 60)
                .collect();
            limbs.dedup();
            assert!(limbs.len() <= 1, "seed {seed}, cluster {cluster}: {limbs:?}");
        }
        // The needles weigh a millionth of a triangle each and move by less than ten units.
        let residual = out.report.steps.last().unwrap().residual;
        assert!(residual < 1e-3, "seed {seed}: {residual}");
        assert!(out.report.cost <= out.report.least_squares_cost, "seed {seed}");
    }
}

#[test]
fn thousands_of_rigid_pieces_share_few_clusters() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut soup = Soup::default();
    let motions: Vec<_> = (0..3).map(|_| path(&mut random, 6, 1.0)).collect();
    for piece in 0..1500 {
        let centre = DVec3::from_array(std::array::from_fn(|_| random.f64() * 10.0));
        soup.add_strip(&mut random, 3, centre, 0.5, &motions[piece % 3], 0.0);
    }
    let out = decompose(&soup, &DecomposeSettings::default());
    assert_eq!((out.clusters.len(), out.report.rigid_components), (3, 1500));
    let shattered = (0..1500).fold(Soup::default(), |mut soup, _| {
        let motion = path(&mut random, 6, 1.0);
        soup.add_strip(&mut random, 3, DVec3::ZERO, 0.5, &motion, 0.0);
        soup
    });
    decompose(&shattered, &DecomposeSettings::default());
}

#[test]
fn the_same_on_any_number_of_threads() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut soup = Soup::default();
    for piece in 0..6 {
        let motion = path(&mut random, 40, 1.4);
        soup.add_strip(&mut random, 300, DVec3::X * f64::from(piece), 1.0, &motion, 0.1);
    }
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let out = pool.install(|| decompose(&soup, &DecomposeSettings::default()));
        (out.clusters, out.cluster_of, out.rest_key)
    };
    let one = run(1);
    assert!(one.0.len() > 3);
    for threads in [2, 3, 7] {
        assert!(run(threads) == one, "{threads} threads");
    }
}
