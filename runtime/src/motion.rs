use crate::{Affine, Asset, Pose, PoseEvaluator, instance_state::InstanceState};
use restpose_formats::{ModelView, rows::CacheRow};

/// An instance's way through a time interval: from the state that it has to another.
///
/// At time s every number of its transform, palette, morph weights and cache frames is `(1 − s)·a + s·b`, in `f32`, cache
/// frames in `f64`. So vertices of skins move on parabolas, on straight lines where the transform or the palette rests.
#[derive(Debug)]
pub(crate) struct Motion {
    pub end: InstanceState,
    /// Both ends, as of the last commit.
    poses: [Pose; 2],
}

impl Motion {
    pub(crate) fn to(end: &InstanceState) -> Self {
        Self {
            end: end.clone(),
            poses: [Pose::default(), Pose::default()],
        }
    }

    /// Evaluates both ends.
    pub(crate) fn update(&mut self, asset: &Asset, begin: &InstanceState, evaluator: &mut PoseEvaluator) {
        let [first, last] = &mut self.poses;
        begin.pose.evaluate(asset.model(), evaluator, first);
        self.end.pose.evaluate(asset.model(), evaluator, last);
    }

    /// The poses of both ends.
    pub(crate) fn poses(&self) -> &[Pose; 2] {
        &self.poses
    }

    /// Per morph target, the largest magnitude of its weight.
    pub(crate) fn largest_weights(&self) -> Vec<f32> {
        let [a, b] = &self.poses;
        let weights = a.morph_weights.iter().zip(&b.morph_weights);
        weights.map(|(a, b)| a.abs().max(b.abs())).collect()
    }

    /// Per vertex cache, the frames between which its vertices move on straight lines: both ends and the keys between them.
    pub(crate) fn breakpoints(&self, model: &ModelView) -> Vec<Vec<f64>> {
        let [a, b] = &self.poses;
        let ends = a.cache_frames.iter().zip(&b.cache_frames);
        let of = |(cache, (a, b)): (&CacheRow, (&f64, &f64))| {
            let (first, last) = (a.min(*b), a.max(*b));
            // Beyond the keys nothing moves.
            let keys = (0..cache.key_count).map(f64::from);
            let between = keys.filter(|key| first < *key && *key < last);
            [first].into_iter().chain(between).chain([last]).collect()
        };
        model.caches.iter().zip(ends).map(of).collect()
    }

    /// The transform at a time from 0 to 1. `begin` is where the interval begins.
    pub(crate) fn transform_at(&self, begin: &InstanceState, time: f32) -> Affine {
        between(&begin.transform, &self.end.transform, time)
    }

    /// The pose at a time from 0 to 1.
    pub(crate) fn pose_at(&self, time: f32, out: &mut Pose) {
        let [a, b] = &self.poses;
        out.palette.clear();
        let palettes = a.palette.iter().zip(&b.palette);
        out.palette.extend(palettes.map(|(a, b)| between(a, b, time)));
        out.morph_weights.clear();
        let weights = a.morph_weights.iter().zip(&b.morph_weights);
        out.morph_weights.extend(weights.map(|(a, b)| mix(*a, *b, time)));
        out.cache_frames.clear();
        let frames = a.cache_frames.iter().zip(&b.cache_frames);
        let time = f64::from(time);
        out.cache_frames
            .extend(frames.map(|(a, b)| (1.0 - time) * a + time * b));
    }
}

/// At time 0 `a`, at time 1 `b`, exactly.
fn mix(a: f32, b: f32, time: f32) -> f32 {
    (1.0 - time) * a + time * b
}

fn between(a: &Affine, b: &Affine, time: f32) -> Affine {
    Affine {
        columns: std::array::from_fn(|j| std::array::from_fn(|k| mix(a.columns[j][k], b.columns[j][k], time))),
    }
}
