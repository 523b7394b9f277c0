//! The bundled vase that shatters: what its files promise, and that the baker finds its motion free by itself, from a
//! vertex cache and from a folder of OBJ files.

use restpose_bake::{
    BakeSettings, MotionClass, NoProgress, bake,
    import::{ImportSettings, import_files},
    verify::{VerifySettings, verify},
};
use restpose_runtime::Asset;
use restpose_samples::{obj_writer::obj_bytes, shatter::shatter};
use restpose_tests::cache_reference::CacheReference;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

fn files() -> [PathBuf; 2] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    ["shatter.obj", "shatter.pc2"].map(|name| folder.join(name))
}

/// The triangles of each piece of a group, by points: pieces share none.
fn pieces(reference: &CacheReference, group: &str) -> Vec<Vec<[usize; 3]>> {
    let faces = reference.obj().faces.iter();
    let triangles = faces
        .filter(|face| face.group.as_deref() == Some(group))
        .flat_map(|face| face.triangles());
    // Per point, the least point known to be joined with it.
    let mut joined: Vec<usize> = (0..reference.obj().positions.len()).collect();
    let least = |joined: &[usize], mut point: usize| {
        while joined[point] != point {
            point = joined[point];
        }
        point
    };
    let triangles: Vec<[usize; 3]> = triangles.collect();
    for corners in &triangles {
        let roots = corners.map(|point| least(&joined, point));
        let first = roots.iter().copied().min().expect("three");
        roots.iter().for_each(|root| joined[*root] = first);
    }
    let mut pieces: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for corners in triangles {
        pieces.entry(least(&joined, corners[0])).or_default().push(corners);
    }
    pieces.into_values().collect()
}

fn assert_closed_and_outward(triangles: &[[usize; 3]], points: &[[f32; 3]]) {
    let mut balance: BTreeMap<[usize; 2], i32> = BTreeMap::new();
    let mut sixfold_volume = 0.0;
    for [a, b, c] in triangles {
        for [from, to] in [[*a, *b], [*b, *c], [*c, *a]] {
            *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
        let [a, b, c] = [*a, *b, *c].map(|point| points[point].map(f64::from));
        sixfold_volume += a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    assert!(balance.values().all(|sum| *sum == 0), "{triangles:?} is open");
    assert!(sixfold_volume > 0.0, "{triangles:?} is inside out");
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let squares = (0..3).map(|axis| (f64::from(a[axis]) - f64::from(b[axis])).powi(2));
    squares.sum::<f64>().sqrt()
}

#[test]
fn two_thousand_closed_shards_fly_rigidly_and_stay_on_the_slab() {
    let [obj, cache] = files();
    let reference = CacheReference::load(&obj, &cache, None);
    let seconds = reference.frame_seconds();
    assert_eq!((seconds.len(), seconds[9]), (10, 0.75));
    assert_eq!(reference.obj().positions, reference.frame(0));
    assert_eq!(
        [pieces(&reference, "ball").len(), pieces(&reference, "slab").len()],
        [1, 1]
    );
    let shards = pieces(&reference, "vase");
    assert_eq!(shards.len(), 2_016);
    for shard in shards {
        assert_eq!(shard.len(), 8);
        assert_closed_and_outward(&shard, reference.frame(0));
        assert_closed_and_outward(&shard, reference.frame(9));
        let points: Vec<usize> = shard.as_flattened().to_vec();
        let way = |point: &usize| distance(reference.frame(0)[*point], reference.frame(9)[*point]);
        assert!(
            points.iter().map(way).fold(0.0, f64::max) > 1e-3,
            "a shard stays where it is"
        );
        for frame in 1..seconds.len() {
            let (whole, now) = (reference.frame(0), reference.frame(frame));
            for pair in points.windows(2) {
                let change = distance(whole[pair[0]], whole[pair[1]]) - distance(now[pair[0]], now[pair[1]]);
                // Twelve coordinates of up to two, each rounded to f32.
                assert!(change.abs() < 12.0 * 2.0 * f64::from(f32::EPSILON), "{change}");
            }
            for [x, y, z] in points.iter().map(|point| now[*point].map(f64::from)) {
                // The ground is at 0 up to the rounding of sums of about one in f64.
                assert!(y > -1e-14 && x.hypot(z) < 1.28, "frame {frame}: {x} {y} {z}");
            }
        }
    }
}

#[test]
fn its_motion_is_found_to_be_free_for_many_rays_from_either_kind_of_source() {
    let folder = tempfile::tempdir().unwrap();
    let shatter = shatter();
    for (number, frame) in shatter.frames.iter().step_by(3).enumerate() {
        let path = folder.path().join(format!("frame{number}.obj"));
        std::fs::write(path, obj_bytes(frame, &shatter.groups)).unwrap();
    }
    for (inputs, keys) in [(vec![folder.path().to_owned()], 4), (files().to_vec(), 10)] {
        let animation = import_files(&inputs, &ImportSettings::default()).unwrap().animation;
        assert_eq!(animation.caches[0].frame_count(), keys);
        let many = BakeSettings {
            rays_per_frame: 100_000.0,
            // Without boxes at keys, with which fuzzy trees are the faster where keys are close.
            size_worth: 1e9,
            ..BakeSettings::default()
        };
        let baked = bake(&animation, &many, &NoProgress).unwrap();
        let classes = baked.report.parts.iter().map(|part| (part.name.as_str(), part.class));
        assert_eq!(
            classes.collect::<Vec<_>>(),
            [
                ("vase", MotionClass::Free),
                ("ball", MotionClass::Rigid),
                ("slab", MotionClass::Static)
            ]
        );
        let bytes = restpose_formats::write(&baked.model).unwrap();
        let asset = Arc::new(Asset::from_bytes(&bytes).unwrap());
        let settings = VerifySettings {
            rays: 2_000,
            poses: 6,
            pose_source: None,
            seed: 7,
        };
        let report = verify(&asset, &animation, &settings, &NoProgress).unwrap();
        assert_eq!((report.missed, report.wrong), (0, 0), "{:#?}", report.failures);
        assert!(report.hits > 800, "{}", report.hits);
    }
}
