use super::{
    candidate::{Candidate, relate_areas},
    contest::{Round, contest},
    pose_kind::{PoseKind, between_samples},
    report::PoseSpaceFigures,
};
use crate::MeasureError;
use restpose_bake::{BakeSettings, LimitSettings, PoseSpace, import::Animation};
use restpose_formats::Bounds;

/// Files of a scene: four pose spaces, each by both bounds.
pub(super) const FILES: u64 = 8;

/// Table 3.1: the same poses, times of one clip, in files for ever more poses.
pub(super) fn measure_pose_spaces(
    animation: &Animation,
    round: &Round,
) -> Result<(Vec<PoseSpaceFigures>, u64), MeasureError> {
    let settings = round.settings;
    let clip = settings.clip.clone().unwrap_or_else(|| animation.clips[0].label(0));
    let mut candidates = Vec::new();
    for pose_space in [
        PoseSpace::Clip(clip),
        PoseSpace::Clips,
        PoseSpace::Limits(LimitSettings::default()),
        PoseSpace::Arbitrary,
    ] {
        for bounds in [Bounds::Sampled, Bounds::Envelope] {
            let bake = BakeSettings {
                pose_space: pose_space.clone(),
                seed: settings.seed,
                bounds,
                tree: settings.tree,
                ..BakeSettings::default()
            };
            candidates.push(Candidate::new(animation, 0, &bake)?);
            round.progress.advance(1);
        }
    }
    relate_areas(&mut candidates);
    let poses = between_samples(candidates[0].asset.model().samples, settings.poses);
    let round = Round {
        kind: PoseKind::Clip.name(),
        ..*round
    };
    // Files for other pose spaces may keep other bones.
    let (standings, brute_force_rays) = contest(&candidates, 2, &poses, &round)?;
    let rows = candidates.iter().zip(&standings).flat_map(|(candidate, standing)| {
        standing.rays().map(|rays| PoseSpaceFigures {
            file: candidate.file.clone(),
            rays,
        })
    });
    Ok((rows.collect(), brute_force_rays))
}
