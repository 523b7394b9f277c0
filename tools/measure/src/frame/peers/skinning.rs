use super::super::crowd::{Crowd, CrowdPose};
use crate::MeasureError;
use rayon::prelude::*;
use restpose_formats::{ModelView, rows::NONE};
use restpose_runtime::{Affine, Pose, PoseEvaluator, Scene};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Vertices that a task poses.
const VERTICES_PER_TASK: usize = 4096;

/// Poses all vertices of a crowd, as a program does that has no more use for the file: palettes in lanes of four, and of vertex
/// caches all keys as plain positions, between which it interpolates.
pub(super) struct Skinning {
    crowd: Arc<Crowd>,
    /// Keys of all caches that poses lie between: positions by vertex row in the caches' own space.
    keys: BTreeMap<u32, Vec<[f32; 4]>>,
    /// Parts as vertex range and cache row, or `NONE`.
    parts: Vec<(std::ops::Range<usize>, u32)>,
}

/// What a frame needs, kept from one to the next.
#[derive(Default)]
pub(super) struct Scratch(Vec<Posed>);

/// An instance.
#[derive(Default)]
struct Posed {
    evaluator: PoseEvaluator,
    pose: Pose,
    /// World space from rest space, per bone.
    palette: Vec<[[f32; 4]; 4]>,
}

impl Skinning {
    pub(super) fn new(crowd: &Arc<Crowd>) -> Result<Self, MeasureError> {
        let model = crowd.asset.model();
        let part = |part: &restpose_formats::rows::PartRow| {
            let first = part.vertex_first as usize;
            (first..first + part.vertex_count as usize, part.cache)
        };
        Ok(Self {
            crowd: Arc::clone(crowd),
            keys: keys(crowd)?,
            parts: model.parts.iter().map(part).collect(),
        })
    }

    /// Poses all vertices, instance after instance, on the threads of the present pool.
    pub(super) fn vertices_into(&self, pose: usize, scratch: &mut Scratch, vertices: &mut [[f32; 4]]) {
        let crowd = self.crowd.as_ref();
        scratch.0.resize_with(crowd.transforms.len(), Posed::default);
        let crowd_pose = &crowd.poses[pose];
        let instances = scratch.0.par_iter_mut().enumerate();
        instances.for_each(|(instance, posed)| posed.update(crowd, crowd_pose, instance));
        let count = crowd.asset.model().vertices.len() - 1;
        let each = vertices.par_chunks_exact_mut(count).zip(&scratch.0).enumerate();
        each.for_each(|(instance, (vertices, posed))| {
            let pose = crowd_pose.given.get(instance).unwrap_or(&posed.pose);
            let tasks = vertices.par_chunks_mut(VERTICES_PER_TASK).enumerate();
            tasks.for_each(|(task, vertices)| self.pose(task * VERTICES_PER_TASK, pose, &posed.palette, vertices));
        });
    }

    /// Poses the vertices from `first` on.
    fn pose(&self, first: usize, pose: &Pose, palette: &[[[f32; 4]; 4]], vertices: &mut [[f32; 4]]) {
        let model = self.crowd.asset.model();
        for (range, cache) in &self.parts {
            let (from, to) = (range.start.max(first), range.end.min(first + vertices.len()));
            if from >= to {
                continue;
            }
            let own = &mut vertices[from - first..to - first];
            if *cache == NONE {
                skin(model, from, pose, palette, own);
            } else {
                let row = &model.caches[*cache as usize];
                let map = &palette[row.bone as usize];
                let [before, after, share] = between(pose.cache_frames[*cache as usize], row.key_count);
                let [before, after] = [before, after].map(|key| &self.keys[&(key as u32)][from..to]);
                let share = share as f32;
                for ((out, a), b) in own.iter_mut().zip(before).zip(after) {
                    let mixed: [f32; 4] = std::array::from_fn(|k| (1.0 - share) * a[k] + share * b[k]);
                    *out = transform(map, mixed);
                }
            }
        }
    }
}

impl Posed {
    fn update(&mut self, crowd: &Crowd, pose: &CrowdPose, instance: usize) {
        let model = crowd.asset.model();
        let own = match pose.given.get(instance) {
            Some(given) => given,
            None => {
                let seconds = pose.seconds[instance];
                self.evaluator.evaluate(model, crowd.clip(), seconds, &mut self.pose);
                &self.pose
            }
        };
        let transform = crowd.transforms[instance];
        self.palette.clear();
        self.palette.extend(own.palette.iter().map(|bone| {
            let map = transform * *bone;
            map.columns.map(|[x, y, z]| [x, y, z, 0.0])
        }));
    }
}

/// Linear blend skinning, as the runtime's vertex function has it.
fn skin(model: &ModelView, first: usize, pose: &Pose, palette: &[[[f32; 4]; 4]], vertices: &mut [[f32; 4]]) {
    let rows = &model.vertices[first..=first + vertices.len()];
    let has_morphs = !model.morph_first.is_empty();
    for (index, (out, pair)) in vertices.iter_mut().zip(rows.windows(2)).enumerate() {
        let [x, y, z] = pair[0].position_rest;
        let mut rest = [x, y, z, 0.0];
        if has_morphs {
            for delta in model.morph_deltas_of(first + index) {
                let weight = pose.morph_weights[delta.target as usize];
                for k in 0..3 {
                    rest[k] += weight * delta.delta[k];
                }
            }
        }
        let influences = &model.influences[pair[0].influence_first as usize..pair[1].influence_first as usize];
        if let [only] = influences {
            *out = transform(&palette[only.bone as usize], rest);
            continue;
        }
        let mut sum = [0.0; 4];
        for influence in influences {
            let moved = transform(&palette[influence.bone as usize], rest);
            for k in 0..4 {
                sum[k] += influence.weight * moved[k];
            }
        }
        *out = sum;
    }
}

#[inline(always)]
fn transform(map: &[[f32; 4]; 4], point: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|k| ((map[0][k] * point[0] + map[1][k] * point[1]) + map[2][k] * point[2]) + map[3][k])
}

/// Keys around a frame, and the share of the second.
fn between(frame: f64, key_count: u32) -> [f64; 3] {
    let frame = frame.clamp(0.0, f64::from(key_count - 1));
    [frame.floor(), frame.ceil(), frame.fract()]
}

/// The keys that the crowd's poses lie between, posed by the runtime under maps that change nothing.
fn keys(crowd: &Crowd) -> Result<BTreeMap<u32, Vec<[f32; 4]>>, MeasureError> {
    let model = crowd.asset.model();
    let mut needed = BTreeSet::new();
    let (mut evaluator, mut pose) = (PoseEvaluator::default(), Pose::default());
    if !model.caches.is_empty() {
        for seconds in crowd.poses.iter().flat_map(|pose| &pose.seconds) {
            evaluator.evaluate(model, crowd.clip(), *seconds, &mut pose);
            for (frame, cache) in pose.cache_frames.iter().zip(model.caches) {
                let [before, after, _] = between(*frame, cache.key_count);
                needed.extend([before as u32, after as u32]);
            }
        }
    }
    let mut scene = Scene::new();
    let instance = scene.add(&crowd.asset);
    let weights = vec![0.0; model.morph_targets.len()];
    scene.set_palette(instance, &vec![Affine::IDENTITY; model.bones.len()], &weights)?;
    let mut out = BTreeMap::new();
    for key in needed {
        scene.set_cache_frames(instance, &vec![f64::from(key); model.caches.len()])?;
        let frame = scene.commit();
        let vertices = 0..model.vertices.len() as u32 - 1;
        let positions = vertices.filter_map(|vertex| frame.vertex(instance, vertex));
        out.insert(key, positions.map(|[x, y, z]| [x, y, z, 0.0]).collect());
    }
    Ok(out)
}
