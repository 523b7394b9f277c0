use super::{
    candidate::{Candidate, relate_areas},
    contest::{Round, contest},
    pose_kind::PoseKind,
    report::AccuracyFigures,
    thinned::{can_be_thinned, thinned},
};
use crate::MeasureError;
use restpose_bake::{BakeSettings, import::Animation};
use restpose_formats::Bounds;

/// Samples per second of files without samples at key times.
const RATES: [f64; 4] = [30.0, 15.0, 8.0, 4.0];

/// Most envelopes of a cluster, a file each.
const ENVELOPES: [usize; 4] = [1, 4, 16, 64];

/// Poses, as many times as of a kind elsewhere: few rays are lost.
pub(super) const TIMES: u64 = 4;

/// Files of a scene: sampled as `bake` does, sampled at each rate, and each number of envelopes.
pub(super) const FILES: u64 = 1 + RATES.len() as u64 + ENVELOPES.len() as u64;

/// What fewer samples gain and lose, beside envelopes, at times of clips between all samples.
pub(super) fn measure_accuracy(
    animation: &Animation,
    round: &Round,
) -> Result<(Vec<AccuracyFigures>, u64), MeasureError> {
    let as_baked = BakeSettings {
        bounds: Bounds::Sampled,
        tree: round.settings.tree,
        ..BakeSettings::default()
    };
    let mut candidates = vec![Candidate::new(animation, 0, &as_baked)?];
    let mut steps = vec![Some(as_baked.sample_step_seconds)];
    if can_be_thinned(animation) {
        for rate in RATES {
            let step = 1.0 / rate;
            let candidate = thinned(animation, candidates[0].asset.model(), step)?;
            candidates.push(candidate);
            steps.push(Some(step));
        }
    }
    for envelopes in ENVELOPES {
        let bake = BakeSettings {
            bounds: Bounds::Envelope,
            envelopes,
            tree: round.settings.tree,
            ..BakeSettings::default()
        };
        candidates.push(Candidate::new(animation, 0, &bake)?);
        steps.push(None);
    }
    relate_areas(&mut candidates);
    round.progress.advance(FILES);
    let settings = round.settings;
    let kind = PoseKind::Clip;
    let count = settings.poses * TIMES as usize;
    let poses = kind.draw(animation, candidates[0].asset.model(), settings.seed, count);
    let round = Round {
        kind: kind.name(),
        ..*round
    };
    let (standings, brute_force_rays) = contest(&candidates, candidates.len(), &poses, &round)?;
    let mut rows = Vec::new();
    for ((place, candidate), (step, standing)) in candidates.iter().enumerate().zip(steps.iter().zip(&standings)) {
        rows.extend(standing.rays().map(|rays| AccuracyFigures {
            file: candidate.file.clone(),
            sample_step_seconds: *step,
            keys_sampled: place == 0,
            rays,
        }));
    }
    Ok((rows, brute_force_rays))
}
