mod motion;
mod piece;
#[cfg(test)]
mod tests;

use fastrand::Rng;
pub use motion::Motion;
use motion::{Map, maps, vector};
use nalgebra::Vector3;
use piece::random_piece;
use restpose_bake::import::{
    Animation, Channel, ChannelTarget, Clip, Local, MAX_MAGNITUDE, Mesh, Node, Part, Primitive, VertexCache,
};
use restpose_formats::rows::Interpolation;
use std::collections::BTreeMap;

const FRAMES_PER_SECOND: f64 = 24.0;

/// What a random vertex cache is made of.
#[derive(Clone, Copy, Debug)]
pub struct CacheRecipe {
    /// Seed.
    pub seed: u64,
    /// Frames, at least one.
    pub frames: usize,
    /// Parts that share the cache, at least one.
    pub parts: usize,
    /// Pieces of each part, at least one; each moves on its own.
    pub pieces: usize,
    /// Points of each piece, at least three.
    pub points: usize,
    /// Triangles of each part between points of any of its pieces.
    pub bridges: usize,
    /// What a piece's motion is drawn from; at least one.
    pub motions: &'static [Motion],
    /// How far each point strays from its piece's motion in each frame, in units of `scale`.
    pub residual: f64,
    /// Unit of every length; a piece is at most 0.6 wide. The whole is made smaller where it would leave ±1e30.
    pub scale: f64,
    /// Where the model is, in units of `scale`.
    pub offset: f64,
    /// Whether the parts' nodes are moved by the clip as well.
    pub moving_nodes: bool,
}

impl Default for CacheRecipe {
    fn default() -> Self {
        Self {
            seed: 1,
            frames: 12,
            parts: 1,
            pieces: 4,
            points: 12,
            bridges: 4,
            motions: Motion::ALL,
            residual: 0.02,
            scale: 1.0,
            offset: 0.0,
            moving_nodes: false,
        }
    }
}

/// Pieces under a vertex cache that moves each in its own way, and a clip that plays it. No mesh anyone would draw,
/// but each thing that can go wrong in clustering, fitting and traversal happens in it: triangles across unrelated
/// pieces, maps without an inverse at or between frames, slivers, points, vertices that share a point of the cache,
/// points that no vertex uses, parts of several primitives.
#[must_use]
pub fn random_cache(recipe: &CacheRecipe) -> Animation {
    let mut random = Rng::with_seed(recipe.seed);
    // Frame after frame, each with the points of the pieces so far.
    let mut frames: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); recipe.frames];
    let mut parts: Vec<Vec<[usize; 3]>> = Vec::new();
    for _ in 0..recipe.parts {
        let first = frames[0].len();
        let mut triangles = Vec::new();
        for _ in 0..recipe.pieces {
            let base = frames[0].len();
            let piece = random_piece(recipe.points, &mut random);
            let motion = recipe.motions[random.usize(..recipe.motions.len())];
            let centre = vector(&mut random, 1.0);
            for (frame, map) in frames.iter_mut().zip(maps(motion, recipe.frames, &mut random)) {
                let place = |point| centre + placed(point, &map, recipe.residual, &mut random);
                frame.extend(piece.points.iter().map(place));
            }
            let numbers = piece
                .triangles
                .iter()
                .map(|corners| corners.map(|corner| base + corner));
            triangles.extend(numbers);
        }
        let count = frames[0].len();
        for _ in 0..recipe.bridges {
            triangles.push(std::array::from_fn(|_| random.usize(first..count)));
        }
        parts.push(triangles);
    }
    let cache = VertexCache {
        point_count: frames[0].len(),
        positions: rounded(recipe, &frames),
    };

    let mut animation = Animation {
        source_name: format!("random cache {}", recipe.seed),
        clips: vec![Clip {
            name: "clip".to_owned(),
            channels: vec![frame_channel(recipe.frames, &mut random)],
        }],
        ..Animation::default()
    };
    for (number, triangles) in parts.into_iter().enumerate() {
        let name = format!("part {number}");
        let cut = random.usize(..triangles.len());
        let halves = [&triangles[..cut], &triangles[cut..]];
        let filled = halves.into_iter().filter(|half| !half.is_empty());
        let primitives = filled.enumerate();
        animation.meshes.push(Mesh {
            name: name.clone(),
            primitives: primitives
                .map(|(number, half)| primitive(number, half, &cache, &mut random))
                .collect(),
            morph_target_count: 0,
        });
        animation.nodes.push(Node {
            name: name.clone(),
            parent: None,
            local: UNMOVED,
            weights: Vec::new(),
        });
        if recipe.moving_nodes {
            let channels = node_channels(number, recipe.scale, &mut random);
            animation.clips[0].channels.extend(channels);
        }
        animation.parts.push(Part {
            name,
            node: number,
            mesh: number,
            skin: None,
            cache: Some(0),
        });
    }
    animation.caches.push(cache);
    animation
}

fn placed(point: &Vector3<f64>, map: &Map, residual: f64, random: &mut Rng) -> Vector3<f64> {
    map.linear * point + map.shift + vector(random, map.stray) + vector(random, residual)
}

/// The frames at the recipe's scale and place, as small as `MAX_MAGNITUDE` demands.
fn rounded(recipe: &CacheRecipe, frames: &[Vec<Vector3<f64>>]) -> Vec<[f32; 3]> {
    let whole = |point: &Vector3<f64>| point.map(|x| (x + recipe.offset) * recipe.scale);
    let points = || frames.iter().flatten().map(whole);
    let largest = points().fold(0.0, |largest: f64, point| largest.max(point.amax()));
    let shrink = (f64::from(MAX_MAGNITUDE) / largest).min(1.0);
    points()
        .map(|point| point.map(|x| (x * shrink) as f32).into())
        .collect()
}

/// One key per frame at uneven times, or one at each end.
fn frame_channel(frames: usize, random: &mut Rng) -> Channel {
    let last = frames - 1;
    let start = if random.bool() { 0.0 } else { 0.7 };
    let seconds = |frame: usize| (start + frame as f64 / FRAMES_PER_SECOND) as f32;
    let mut keys: Vec<(f32, f32)> = vec![(seconds(0), 0.0), (seconds(last), last as f32)];
    keys.dedup();
    if random.bool() {
        let late = |random: &mut Rng| random.f32() * 0.9 / FRAMES_PER_SECOND as f32;
        keys = (0..frames)
            .map(|frame| (seconds(frame) + late(random), frame as f32))
            .collect();
    }
    let (times, values) = keys.into_iter().unzip();
    Channel {
        node: 0,
        target: ChannelTarget::Frame,
        interpolation: Interpolation::Linear,
        times,
        values,
    }
}

/// One corner in eight gets a vertex of its own; the others share one per point.
fn primitive(number: usize, triangles: &[[usize; 3]], cache: &VertexCache, random: &mut Rng) -> Primitive {
    let mut points: Vec<u32> = Vec::new();
    let mut shared: BTreeMap<usize, u32> = BTreeMap::new();
    let mut vertex = |point: usize| -> u32 {
        let fresh = points.len() as u32;
        let own = random.u32(..8) == 0;
        let vertex = if own {
            fresh
        } else {
            *shared.entry(point).or_insert(fresh)
        };
        if vertex == fresh {
            points.push(point as u32);
        }
        vertex
    };
    let triangles = triangles.iter().map(|corners| corners.map(&mut vertex)).collect();
    Primitive {
        source_primitive: number,
        positions: points.iter().map(|point| cache.frame(0)[*point as usize]).collect(),
        triangles,
        points,
        ..Primitive::default()
    }
}

const UNMOVED: Local = Local::Trs {
    translation: [0.0; 3],
    rotation: [0.0, 0.0, 0.0, 1.0],
    scale: [1.0; 3],
};

/// A node's place and turn at three times.
fn node_channels(node: usize, scale: f64, random: &mut Rng) -> [Channel; 2] {
    let mut values = |width: usize, magnitude: f64| -> Vec<f32> {
        (0..3 * width)
            .map(|_| ((random.f64() * 2.0 - 1.0) * magnitude) as f32)
            .collect()
    };
    let channel = |target, values| Channel {
        node,
        target,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.2, 0.4],
        values,
    };
    [
        channel(ChannelTarget::Translation, values(3, 0.5 * scale)),
        channel(ChannelTarget::Rotation, values(4, 1.0)),
    ]
}
