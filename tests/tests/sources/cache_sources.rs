//! Vertex caches as imported against an independent reading of the same files, and the bundled goose against its promises.

use restpose_bake::import::{Animation, ChannelTarget, ImportSettings, import_files};
use restpose_formats::rows::Interpolation;
use restpose_samples::{
    obj_writer::{FaceGroup, obj_bytes},
    point_cache_writer::{mdd_bytes, pc2_bytes},
};
use restpose_tests::{CacheRecipe, cache_reference::CacheReference, random_cache};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// The bundled meshes with their caches, the goose first, then those of the optional scene folder beside the repository.
fn scenes() -> Vec<[PathBuf; 2]> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let samples = root.join("samples/scenes");
    let bundled = |name: &str| ["obj", "pc2"].map(|extension| samples.join(name).with_extension(extension));
    let mut scenes = vec![bundled("goose"), bundled("shatter")];
    for name in ["chicken", "cow", "horse", "elephant"] {
        let stem = root.join("../shared/scenes").join(name).join(name);
        let files = [stem.with_extension("obj"), stem.with_extension("pc2")];
        if files.iter().all(|file| file.is_file()) {
            scenes.push(files);
        }
    }
    scenes
}

fn imported(inputs: &[PathBuf], frame_rate: Option<f64>) -> Animation {
    let settings = ImportSettings {
        frame_rate,
        ..ImportSettings::default()
    };
    let imported = import_files(inputs, &settings).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.faults, []);
    imported.animation
}

/// Faces, positions at frames bit for bit, and times.
fn assert_equal(animation: &Animation, reference: &CacheReference) {
    let cache = &animation.caches[0];
    let seconds = reference.frame_seconds();
    assert_eq!(animation.caches.len(), 1);
    assert_eq!(cache.frame_count(), seconds.len());
    assert_eq!(cache.point_count, reference.obj().positions.len());
    for frame in 0..seconds.len() {
        let bits = |points: &[[f32; 3]]| -> Vec<[u32; 3]> { points.iter().map(|p| p.map(f32::to_bits)).collect() };
        assert_eq!(bits(cache.frame(frame)), bits(reference.frame(frame)), "frame {frame}");
    }

    let mut groups: Vec<Option<&str>> = Vec::new();
    for face in &reference.obj().faces {
        if !groups.contains(&face.group.as_deref()) {
            groups.push(face.group.as_deref());
        }
    }
    assert_eq!(animation.parts.len(), groups.len());
    for (part, group) in animation.parts.iter().zip(groups) {
        assert_eq!(part.cache, Some(0));
        if let Some(group) = group {
            assert_eq!(part.name, group);
        }
        let [primitive] = &animation.meshes[part.mesh].primitives[..] else {
            panic!("{} has not one primitive", part.name);
        };
        let points = |corners: &[u32; 3]| corners.map(|corner| primitive.points[corner as usize] as usize);
        let found: Vec<[usize; 3]> = primitive.triangles.iter().map(points).collect();
        let faces = reference
            .obj()
            .faces
            .iter()
            .filter(|face| face.group.as_deref() == group);
        let expected: Vec<[usize; 3]> = faces.flat_map(|face| face.triangles()).collect();
        assert!(found == expected, "the triangles of {}", part.name);
        for (position, point) in primitive.positions.iter().zip(&primitive.points) {
            assert_eq!(position, &cache.frame(0)[*point as usize]);
        }
    }

    let [clip] = &animation.clips[..] else {
        panic!("{} clips", animation.clips.len());
    };
    let [channel] = &clip.channels[..] else {
        panic!("{} channels", clip.channels.len());
    };
    assert_eq!(
        (channel.target, channel.node, channel.interpolation),
        (ChannelTarget::Frame, 0, Interpolation::Linear)
    );
    // Frames between keys are where a straight line puts them, to the rounding of its ends.
    for (frame, exact) in seconds.iter().enumerate() {
        let after = channel.values.partition_point(|value| *value < frame as f32);
        let key = |key: usize| (f64::from(channel.values[key]), f64::from(channel.times[key]));
        let (value, time) = key(after);
        let found = if value == frame as f64 {
            time
        } else {
            let (before, start) = key(after - 1);
            start + (time - start) * (frame as f64 - before) / (value - before)
        };
        let rounding = seconds.iter().fold(0.0, |most: f64, s| most.max(s.abs())) * f64::from(f32::EPSILON);
        assert!(
            (found - exact).abs() <= rounding,
            "frame {frame} at {found}, not {exact}"
        );
    }
}

#[test]
fn every_scene_is_imported_as_the_reference_reads_it() {
    for [obj, cache] in scenes() {
        for rate in [None, Some(30.0)] {
            let reference = CacheReference::load(&obj, &cache, rate);
            assert_equal(&imported(&[obj.clone(), cache.clone()], rate), &reference);
        }
    }
}

/// Points that random caches do not use stay in the files, so that numbers agree.
fn written(animation: &Animation) -> (Vec<Vec<[f32; 3]>>, Vec<FaceGroup>) {
    let cache = &animation.caches[0];
    let frames = (0..cache.frame_count()).map(|frame| cache.frame(frame).to_vec());
    let groups = animation.parts.iter().map(|part| {
        let primitives = animation.meshes[part.mesh].primitives.iter();
        let faces = primitives.flat_map(|primitive| {
            let points = |corners: &[u32; 3]| corners.map(|corner| primitive.points[corner as usize]).to_vec();
            primitive.triangles.iter().map(points)
        });
        FaceGroup {
            name: part.name.clone(),
            faces: faces.collect(),
        }
    });
    (frames.collect(), groups.collect())
}

#[test]
fn random_caches_survive_every_way_of_writing_them() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..24u64 {
        let recipe = CacheRecipe {
            seed,
            frames: [2, 3, 12][seed as usize % 3],
            parts: 1 + seed as usize % 2,
            scale: [1e-30, 1.0, 1e30][seed as usize / 2 % 3],
            ..CacheRecipe::default()
        };
        let random = random_cache(&recipe);
        let (frames, groups) = written(&random);
        let place = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let obj = place("mesh.obj", &obj_bytes(&frames[0], &groups));
        let seconds: Vec<f32> = (0..frames.len())
            .map(|frame| 0.5 + 0.3 * (frame * frame) as f32)
            .collect();
        let pc2 = place("mesh.pc2", &pc2_bytes(&frames, 10.0, 0.25).unwrap());
        let mdd = place("mesh.mdd", &mdd_bytes(&frames, &seconds).unwrap());
        for cache in [pc2, mdd] {
            let reference = CacheReference::load(&obj, &cache, None);
            let animation = imported(&[obj.clone(), cache], None);
            assert_equal(&animation, &reference);
            assert_eq!(animation.caches, random.caches);
        }

        let row: Vec<Vec<u8>> = frames.iter().map(|frame| obj_bytes(frame, &groups)).collect();
        let bytes: Vec<&[u8]> = row.iter().map(Vec::as_slice).collect();
        let names = (0..row.len()).map(|frame| format!("frame{frame}.obj"));
        let files: Vec<PathBuf> = names.zip(&row).map(|(name, bytes)| place(&name, bytes)).collect();
        let animation = imported(&files, Some(12.0));
        assert_equal(&animation, &CacheReference::from_obj_row(&bytes, Some(12.0)));
        assert_eq!(animation.caches, random.caches);
    }
}

/// The positions of each point in `points`, per frame, exactly.
fn tracks(reference: &CacheReference, points: &BTreeSet<usize>) -> Vec<Vec<[f64; 3]>> {
    let frames = 0..reference.frame_seconds().len();
    let place = |frame: usize, point: usize| reference.frame(frame)[point].map(f64::from);
    frames
        .map(|frame| points.iter().map(|point| place(frame, *point)).collect())
        .collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = (0..3).map(|axis| (a[axis] - b[axis]).powi(2));
    squares.sum::<f64>().sqrt()
}

#[test]
fn the_goose_is_jelly_its_ball_rigid_and_its_stage_still() {
    let [obj, cache] = &scenes()[0];
    let reference = CacheReference::load(obj, cache, None);
    assert_eq!(reference.frame_seconds()[83], 83.0 / 24.0);
    assert_eq!(reference.obj().positions, reference.frame(0));
    let faces = &reference.obj().faces;
    let sizes: BTreeSet<usize> = faces.iter().map(|face| face.corners.len()).collect();
    assert_eq!(sizes, BTreeSet::from([3, 4, 5, 6, 32]));
    let [goose, ball, stage] = ["goose", "ball", "stage"].map(|name| {
        let own = faces.iter().filter(|face| face.group.as_deref() == Some(name));
        let triangles: Vec<[usize; 3]> = own.flat_map(|face| face.triangles()).collect();
        let mut balance: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        let mut sixfold_volume = 0.0;
        for [a, b, c] in &triangles {
            for [from, to] in [[*a, *b], [*b, *c], [*c, *a]] {
                *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
            let [a, b, c] = [*a, *b, *c].map(|point| reference.frame(0)[point].map(f64::from));
            sixfold_volume += a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        assert!(balance.values().all(|sum| *sum == 0), "{name} is open");
        assert!(sixfold_volume > 0.0, "{name} is inside out");
        (
            triangles.len(),
            tracks(&reference, &triangles.into_iter().flatten().collect()),
        )
    });
    assert!((1_500..2_500).contains(&(goose.0 + ball.0 + stage.0)));

    assert!(stage.1.iter().all(|frame| *frame == stage.1[0]));
    for pair in ball.1.windows(2) {
        assert!(distance(pair[0][0], pair[1][0]) > 0.01, "the ball rests");
        for (a, b) in (0..ball.1[0].len()).zip(1..ball.1[0].len()) {
            let change = distance(pair[0][a], pair[0][b]) - distance(pair[1][a], pair[1][b]);
            // Eight coordinates of up to three, each rounded to f32.
            assert!(change.abs() < 8.0 * 3.0 * f64::from(f32::EPSILON), "{change}");
        }
    }
    let height = |frame: usize| {
        let heights = || goose.1[frame].iter().map(|point| point[1]);
        assert!(
            heights().all(|y| y > -0.01),
            "the goose is in the stage in frame {frame}"
        );
        heights().fold(0.0, f64::max)
    };
    let heights: Vec<f64> = (0..84).map(height).collect();
    assert!(heights[36] > 2.0 * heights[32] && heights[36] > 1.6 * heights[0]);
    assert!(heights[41] < 0.5 * heights[36], "{heights:?}");
}
