use super::settings::Palettes;
use crate::MeasureError;
use rayon::prelude::*;
use restpose_formats::rows::ClipRow;
use restpose_runtime::{Aabb, Affine, Asset, Frame, InstanceId, Pose, PoseEvaluator, Scene};
use std::sync::Arc;

/// Distance of neighbours over the asset's size: they do not touch.
const SPACING: f32 = 1.25;

/// The fractional part of the golden ratio, times 2⁶⁴: multiples of it spread evenly over a clip however many there are.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Instances of one asset on a grid, each at its own phase of the first clip.
pub(super) struct Crowd {
    pub asset: Arc<Asset>,
    /// World space from asset space.
    pub transforms: Vec<Affine>,
    pub poses: Vec<CrowdPose>,
}

/// A pose of all instances.
pub(super) struct CrowdPose {
    /// Time in the clip, per instance.
    pub seconds: Vec<f32>,
    /// Per instance; empty where frames evaluate them.
    pub given: Vec<Pose>,
}

impl Crowd {
    pub(super) fn new(
        asset: &Arc<Asset>,
        instances: usize,
        poses: usize,
        palettes: Palettes,
    ) -> Result<Self, MeasureError> {
        let mut out = Self {
            asset: Arc::clone(asset),
            transforms: vec![Affine::IDENTITY; instances],
            poses: Vec::with_capacity(poses),
        };
        let mut evaluator = PoseEvaluator::default();
        for pose in 0..poses {
            let seconds: Vec<f32> = (0..instances)
                .map(|instance| out.seconds(instance, (2 * pose + 1) as f64 / (2 * poses) as f64))
                .collect();
            let mut given = Vec::new();
            if palettes == Palettes::Given {
                given.resize_with(instances, Pose::default);
                for (seconds, pose) in seconds.iter().zip(&mut given) {
                    evaluator.evaluate(asset.model(), out.clip(), *seconds, pose);
                }
            }
            out.poses.push(CrowdPose { seconds, given });
        }
        if instances > 1 {
            out.place(&out.bounds_of_one()?);
        }
        Ok(out)
    }

    pub(super) fn clip(&self) -> Option<usize> {
        (!self.asset.model().clips.is_empty()).then_some(0)
    }

    fn seconds(&self, instance: usize, share: f64) -> f32 {
        let Some(ClipRow {
            start_seconds,
            end_seconds,
            ..
        }) = self.asset.model().clips.first()
        else {
            return 0.0;
        };
        let phase = (instance as u64).wrapping_mul(GOLDEN) as f64 / 2f64.powi(64);
        let (start, end) = (f64::from(*start_seconds), f64::from(*end_seconds));
        (start + (share + phase).fract() * (end - start)) as f32
    }

    /// The room that one instance takes, over all poses.
    fn bounds_of_one(&self) -> Result<Aabb, MeasureError> {
        let mut scene = Scene::new();
        let instance = scene.add(&self.asset);
        let mut bounds = Aabb::EMPTY;
        for pose in &self.poses {
            match self.clip() {
                None => scene.set_default_pose(instance)?,
                Some(clip) => scene.play(instance, clip, pose.seconds[0])?,
            }
            bounds = bounds.union(posed_bounds(&scene.commit(), &[instance], &self.asset));
        }
        Ok(bounds)
    }

    /// A square on the ground (glTF's x and z).
    fn place(&mut self, one: &Aabb) {
        let side = (self.transforms.len() as f64).sqrt().ceil() as usize;
        let step = |axis: usize| SPACING * (one.max[axis] - one.min[axis]);
        for (index, transform) in self.transforms.iter_mut().enumerate() {
            let (row, column) = ((index / side) as f32, (index % side) as f32);
            *transform = Affine::from_translation([column * step(0), 0.0, row * step(2)]);
        }
    }

    /// A scene with all instances in their places.
    pub(super) fn scene(&self, asset: &Arc<Asset>) -> Result<(Scene, Vec<InstanceId>), MeasureError> {
        let mut scene = Scene::new();
        let instances: Vec<InstanceId> = self.transforms.iter().map(|_| scene.add(asset)).collect();
        for (instance, transform) in instances.iter().zip(&self.transforms) {
            scene.set_transform(*instance, *transform)?;
        }
        Ok((scene, instances))
    }

    /// Poses all instances of a scene that [`Crowd::scene`] made.
    pub(super) fn pose(&self, scene: &mut Scene, instances: &[InstanceId], pose: usize) -> Result<(), MeasureError> {
        let CrowdPose { seconds, given } = &self.poses[pose];
        for (index, instance) in instances.iter().enumerate() {
            match (given.get(index), self.clip()) {
                (Some(pose), _) => {
                    scene.set_palette(*instance, &pose.palette, &pose.morph_weights)?;
                    if !pose.cache_frames.is_empty() {
                        scene.set_cache_frames(*instance, &pose.cache_frames)?;
                    }
                }
                (None, Some(clip)) => scene.play(*instance, clip, seconds[index])?,
                (None, None) => scene.set_default_pose(*instance)?,
            }
        }
        Ok(())
    }
}

/// The box around all posed vertices. (That of a frame holds whatever the clip's other poses take up, too.)
pub(super) fn posed_bounds(frame: &Frame, instances: &[InstanceId], asset: &Asset) -> Aabb {
    let vertices = asset.model().vertices.len() as u32 - 1;
    let of_one = |instance: &InstanceId| {
        let positions = (0..vertices).filter_map(|vertex| frame.vertex(*instance, vertex));
        Aabb::around(positions)
    };
    let boxes = instances.par_iter().map(of_one);
    boxes.reduce(|| Aabb::EMPTY, |a, b| a.union(b))
}
