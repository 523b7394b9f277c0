use crate::spread::spread;
use restpose_bake::{
    import::Animation,
    verify::{BonePose, PoseFamily, PoseSource, Poses},
};
use restpose_formats::{ModelView, rows::SampleRow};

/// Where poses come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PoseKind {
    /// Clips at times in the middle between two samples.
    Clip,
    /// The maps of two poses of clips, blended entry by entry.
    Blend,
    /// Every joint's rotation drawn from all rotations alike.
    Ragdoll,
}

impl PoseKind {
    pub const ALL: [Self; 3] = [Self::Clip, Self::Blend, Self::Ragdoll];

    pub fn name(self) -> &'static str {
        match self {
            Self::Clip => "clip",
            Self::Blend => "blend",
            Self::Ragdoll => "ragdoll",
        }
    }

    /// Up to `count` poses; none where the scene has no joints to turn. `model` is a bake of `animation` for all clips.
    pub fn draw(self, animation: &Animation, model: &ModelView, seed: u64, count: usize) -> Vec<BonePose> {
        let family = match self {
            Self::Clip => return between_samples(model.samples, count),
            Self::Blend => PoseFamily::Blend,
            Self::Ragdoll => PoseFamily::Ragdoll,
        };
        let mut poses = Poses::new(animation, model, PoseSource::Random, seed, 1);
        // Families take turns.
        let kinds = poses.families().len() as u64;
        let Some(first) = poses.families().iter().position(|known| *known == family) else {
            return Vec::new();
        };
        (0..count as u64)
            .map(|round| poses.pose(first as u64 + round * kinds).bones)
            .collect()
    }
}

/// Up to `count` times in the middle between two samples of a clip, spread evenly; the samples themselves where no clip
/// has two.
pub(super) fn between_samples(samples: &[SampleRow], count: usize) -> Vec<BonePose> {
    let pairs = samples.windows(2).filter(|pair| pair[0].clip == pair[1].clip);
    let mut times: Vec<SampleRow> = pairs
        .map(|pair| SampleRow {
            clip: pair[0].clip,
            seconds: ((f64::from(pair[0].seconds) + f64::from(pair[1].seconds)) / 2.0) as f32,
        })
        .collect();
    if times.is_empty() {
        times.extend_from_slice(samples);
    }
    spread(count, times.len())
        .into_iter()
        .map(|place| BonePose::Clip(times[place]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::rows::NONE;

    #[test]
    fn times_lie_in_the_middle_between_samples_of_one_clip() {
        let at = |clip, seconds| SampleRow { clip, seconds };
        let samples = [
            at(NONE, 0.0),
            at(0, 0.0),
            at(0, 1.0),
            at(0, 3.0),
            at(1, 0.0),
            at(1, 0.5),
        ];
        let clip = |clip, seconds| BonePose::Clip(at(clip, seconds));
        assert_eq!(
            between_samples(&samples, 9),
            [clip(0, 0.5), clip(0, 2.0), clip(1, 0.25)]
        );
        assert_eq!(between_samples(&samples, 1), [clip(0, 2.0)]);
        assert_eq!(between_samples(&samples[..2], 9), [clip(NONE, 0.0), clip(0, 0.0)]);
    }
}
