use super::{
    SourcePose,
    pose_source::{PoseFamily, PoseSource},
    random_map::instance_transform,
    random_pose::{RandomPoses, clip_time},
};
use crate::import::Animation;
use fastrand::Rng;
use restpose_formats::{
    ModelView,
    rows::{CacheRow, NONE, SampleRow},
};
use restpose_runtime::{Affine, InstanceId, PoseError, Scene};

/// How bones and morph weights stand.
#[derive(Clone, Debug, PartialEq)]
pub enum BonePose {
    /// A clip of the file at a time, or with `NONE` the pose without any clip.
    Clip(SampleRow),
    /// As [`Scene::set_palette`] takes it.
    Palette {
        /// Asset space from rest space, one map per bone row.
        palette: Vec<Affine>,
        /// One weight per morph target row.
        morph_weights: Vec<f32>,
    },
}

/// A pose to verify.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnPose {
    /// Its number, from 0.
    pub index: u64,
    /// Row of the sample section, where it comes from there.
    pub sample: Option<usize>,
    /// Where it is random.
    pub family: Option<PoseFamily>,
    /// Bones and morph weights.
    pub bones: BonePose,
    /// Frame of each vertex cache.
    pub cache_frames: Vec<f64>,
    /// World space from asset space.
    pub transform: Affine,
    /// For the rays of this pose.
    pub ray_seed: u64,
}

impl DrawnPose {
    /// Poses an instance alike, but for the transform.
    ///
    /// # Errors
    /// [`PoseError`], when the instance is not of the file that the pose was drawn for.
    pub fn set(&self, scene: &mut Scene, instance: InstanceId) -> Result<(), PoseError> {
        match &self.bones {
            BonePose::Clip(at) if at.clip == NONE => scene.set_default_pose(instance)?,
            BonePose::Clip(at) => scene.play(instance, at.clip as usize, at.seconds)?,
            BonePose::Palette { palette, morph_weights } => scene.set_palette(instance, palette, morph_weights)?,
        }
        scene.set_cache_frames(instance, &self.cache_frames)
    }
}

/// Draws the poses of a source.
///
/// Guarantee: a pose depends on the file, the seed and its own number alone; a sampled one on the number of poses, too.
pub struct Poses<'a> {
    model: &'a ModelView<'a>,
    source: PoseSource,
    seed: u64,
    count: u64,
    random: RandomPoses<'a>,
    families: Vec<PoseFamily>,
}

impl<'a> Poses<'a> {
    /// `count` poses from `source`. `model` is a bake of `animation`.
    #[must_use]
    pub fn new(animation: &'a Animation, model: &'a ModelView<'a>, source: PoseSource, seed: u64, count: u64) -> Self {
        let random = RandomPoses::new(animation, model, SourcePose::new(animation, model).size());
        Self {
            model,
            source,
            seed,
            count: count.max(1),
            families: random.families(),
            random,
        }
    }

    /// The families that random poses of this file belong to.
    #[must_use]
    pub fn families(&self) -> &[PoseFamily] {
        &self.families
    }

    /// The pose with this number. Every second one, and of each family every second one, is transformed.
    pub fn pose(&mut self, index: u64) -> DrawnPose {
        // Numbers next to each other must not share a part of their sequences with seeds next to each other.
        let start = Rng::with_seed(self.seed).u64(..).wrapping_add(index);
        let random = &mut Rng::with_seed(start);
        // One of four, and not always an odd or an even one.
        let at_key = index % 4 == index / 4 % 4;
        let ray_seed = random.u64(..);
        let transform = instance_transform(random);
        let cache_frames = cache_frames(self.model, at_key, random);
        let (mut sample, mut family, mut round) = (None, None, index);
        let bones = match self.source {
            PoseSource::Samples => {
                let samples = self.model.samples.len();
                let row = (u128::from(index) * samples as u128 / u128::from(self.count)) as usize;
                sample = (row < samples).then_some(row);
                // A file without samples still has the pose without any clip.
                BonePose::Clip(self.model.samples.get(row).copied().unwrap_or(STILL))
            }
            PoseSource::Random if !self.families.is_empty() => {
                let kinds = self.families.len() as u64;
                let drawn = self.families[(index % kinds) as usize];
                family = Some(drawn);
                round = index % kinds + index / kinds;
                let (palette, morph_weights) = self.random.draw(drawn, random);
                BonePose::Palette { palette, morph_weights }
            }
            PoseSource::Clips | PoseSource::Random => BonePose::Clip(clip_time(self.model, at_key, random)),
        };
        DrawnPose {
            index,
            sample,
            family,
            bones,
            cache_frames,
            transform: if round.is_multiple_of(2) {
                Affine::IDENTITY
            } else {
                transform
            },
            ray_seed,
        }
    }
}

const STILL: SampleRow = SampleRow {
    clip: NONE,
    seconds: 0.0,
};

/// Where each vertex cache stands: at a key, or anywhere between its first and last.
fn cache_frames(model: &ModelView, at_key: bool, random: &mut Rng) -> Vec<f64> {
    let frame = |cache: &CacheRow| {
        let last = cache.key_count - 1;
        if at_key {
            f64::from(random.u32(0..=last))
        } else {
            random.f64() * f64::from(last)
        }
    };
    model.caches.iter().map(frame).collect()
}
