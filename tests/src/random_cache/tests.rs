//! What every user of a random cache relies on.

use super::{CacheRecipe, Motion, piece::bipyramid, random_cache};
use restpose_bake::import::{Animation, ChannelTarget, MAX_MAGNITUDE};
use std::collections::BTreeMap;

/// f32 rounding of coordinates up to a few thousand, after a teleport.
const ROUNDING: f64 = 1e-3;

fn recipes() -> impl Iterator<Item = CacheRecipe> {
    (0..200u64).map(|seed| CacheRecipe {
        seed,
        frames: [1, 2, 3, 40][seed as usize % 4],
        parts: 1 + seed as usize % 3,
        pieces: 1 + seed as usize % 5,
        points: 3 + seed as usize % 17,
        bridges: seed as usize % 2 * 3,
        scale: [1e-30, 1.0, 1e30][seed as usize % 3],
        offset: [0.0, 1e7][seed as usize / 3 % 2],
        moving_nodes: seed % 7 == 0,
        ..CacheRecipe::default()
    })
}

#[test]
fn every_promise_of_an_animation_holds() {
    for recipe in recipes() {
        let animation = random_cache(&recipe);
        let cache = &animation.caches[0];
        assert_eq!(cache.frame_count(), recipe.frames);
        assert_eq!(cache.positions.len(), recipe.frames * cache.point_count);
        let numbers = cache.positions.iter().flatten();
        assert!(numbers.clone().all(|x| x.is_finite() && x.abs() <= MAX_MAGNITUDE));
        assert!(numbers.clone().any(|x| *x != 0.0), "{recipe:?}");
        assert_eq!(animation.parts.len(), recipe.parts);
        for part in &animation.parts {
            assert_eq!((part.cache, part.skin), (Some(0), None));
            assert!(part.node < animation.nodes.len());
            let primitives = &animation.meshes[part.mesh].primitives;
            assert!(!primitives.is_empty());
            for primitive in primitives {
                assert!(!primitive.triangles.is_empty());
                assert_eq!(primitive.positions.len(), primitive.points.len());
                for (position, point) in primitive.positions.iter().zip(&primitive.points) {
                    assert_eq!(*position, cache.frame(0)[*point as usize]);
                }
                let mut corners = primitive.triangles.iter().flatten();
                assert!(corners.all(|corner| (*corner as usize) < primitive.positions.len()));
            }
        }
        for channel in &animation.clips[0].channels {
            assert!(channel.times.is_sorted_by(|a, b| a < b), "{recipe:?}: {channel:?}");
            assert!(channel.times.iter().chain(&channel.values).all(|x| x.is_finite()));
        }
        let channel = &animation.clips[0].channels[0];
        assert_eq!((channel.node, channel.target), (0, ChannelTarget::Frame));
        assert_eq!(channel.values.len(), channel.times.len());
        assert_eq!(
            (channel.values[0], channel.values.last().copied()),
            (0.0, Some((recipe.frames - 1) as f32))
        );
    }
}

#[test]
fn a_seed_gives_the_same_cache_every_time_and_another_seed_another() {
    let recipe = CacheRecipe::default();
    assert_eq!(random_cache(&recipe), random_cache(&recipe));
    assert_ne!(random_cache(&recipe), random_cache(&CacheRecipe { seed: 2, ..recipe }));
}

#[test]
fn vertices_are_split_and_triangles_bridge_pieces() {
    let animation = random_cache(&CacheRecipe::default());
    let mut points: Vec<u32> = primitives(&animation).flat_map(|p| p.points.clone()).collect();
    let vertices = points.len();
    points.sort_unstable();
    points.dedup();
    assert!(points.len() < vertices);
    let mut spans =
        primitives(&animation).flat_map(|p| p.triangles.iter().map(|t| t.map(|c| p.points[c as usize] / 12)));
    assert!(spans.any(|[a, b, c]| a != b || b != c));
}

fn primitives(animation: &Animation) -> impl Iterator<Item = &restpose_bake::import::Primitive> {
    animation.meshes.iter().flat_map(|mesh| &mesh.primitives)
}

/// One exact piece of one motion, over many seeds: `[frame][point]`.
fn pieces(motion: &'static [Motion]) -> impl Iterator<Item = Vec<Vec<[f64; 3]>>> {
    (0..24).map(move |seed| {
        let animation = random_cache(&CacheRecipe {
            seed,
            frames: 40,
            pieces: 1,
            bridges: 0,
            motions: motion,
            residual: 0.0,
            ..CacheRecipe::default()
        });
        let cache = &animation.caches[0];
        let frames = 0..cache.frame_count();
        frames
            .map(|frame| cache.frame(frame).iter().map(|p| p.map(f64::from)).collect())
            .collect()
    })
}

fn distance(frame: &[[f64; 3]], a: usize, b: usize) -> f64 {
    let squares = (0..3).map(|axis| (frame[a][axis] - frame[b][axis]).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Six times the volume that four points span, handed.
fn volume(frame: &[[f64; 3]], points: [usize; 4]) -> f64 {
    let [a, b, c] =
        [1, 2, 3].map(|i| -> [f64; 3] { std::array::from_fn(|axis| frame[points[i]][axis] - frame[points[0]][axis]) });
    let cross = [
        b[1] * c[2] - b[2] * c[1],
        b[2] * c[0] - b[0] * c[2],
        b[0] * c[1] - b[1] * c[0],
    ];
    (0..3).map(|axis| a[axis] * cross[axis]).sum()
}

#[test]
fn rigid_motions_keep_lengths_and_handedness() {
    for motion in Motion::RIGID.chunks(1) {
        let mut moved = false;
        for frames in pieces(motion) {
            for frame in &frames {
                for (a, b) in [(0, 1), (3, 7), (10, 11)] {
                    let change = distance(frame, a, b) - distance(&frames[0], a, b);
                    assert!(change.abs() < ROUNDING, "{motion:?}: {change}");
                }
                let change = volume(frame, [0, 1, 5, 11]) - volume(&frames[0], [0, 1, 5, 11]);
                assert!(change.abs() < ROUNDING, "{motion:?}: {change}");
            }
            moved |= frames.iter().any(|frame| *frame != frames[0]);
        }
        assert_eq!(moved, motion != [Motion::Still]);
    }
}

#[test]
fn other_motions_do_what_they_say() {
    let volumes = |motion| -> Vec<f64> {
        let frames = pieces(motion).flat_map(|frames| frames.into_iter().map(|f| volume(&f, [0, 1, 5, 11])));
        frames.collect()
    };
    let steps = |motion| -> f64 {
        let all = pieces(motion).flat_map(|frames| {
            let pairs: Vec<f64> = frames.windows(2).map(|w| (w[1][0][0] - w[0][0][0]).abs()).collect();
            pairs
        });
        all.fold(0.0, f64::max)
    };
    let flips = |motion| {
        pieces(motion)
            .filter(|frames| {
                let volumes = || frames.iter().map(|frame| volume(frame, [0, 1, 5, 11]));
                volumes().any(|v| v > 1e-4) && volumes().any(|v| v < -1e-4)
            })
            .count()
    };
    assert!(flips(&[Motion::Mirror]) > 5);
    let widths = pieces(&[Motion::Collapse]).flat_map(|f| f.into_iter().map(|f| distance(&f, 0, 1)));
    assert!(widths.filter(|width| *width == 0.0).count() > 40);
    assert!(
        volumes(&[Motion::Swell])
            .into_iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()))
            > 100.0
    );
    assert!(steps(&[Motion::Teleport]) > 500.0);
    let free = pieces(&[Motion::Free]).next().expect("a piece");
    assert!((distance(&free[0], 0, 1) - distance(&free[1], 0, 1)).abs() > 0.01);
}

#[test]
fn bipyramids_are_closed_and_outward() {
    for points in 5..40 {
        let piece = bipyramid(points);
        let mut balance: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        let mut sixfold_volume = 0.0;
        for [a, b, c] in piece.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
            let corner = |corner: usize| piece.points[corner];
            sixfold_volume += corner(a).dot(&corner(b).cross(&corner(c)));
        }
        assert!(balance.values().all(|sum| *sum == 0));
        assert!(sixfold_volume > 0.01);
    }
}
