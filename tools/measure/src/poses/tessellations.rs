use super::{
    candidate::{Candidate, relate_areas},
    contest::{Round, contest},
    pose_kind::PoseKind,
    report::{BoundsFigures, TessellationFigures},
};
use crate::MeasureError;
use restpose_bake::{BakeSettings, import::Animation, subdivide::subdivide};
use restpose_formats::Bounds;

/// Most envelopes of a cluster, a file each. So many as the last are a stretch between two samples each, or a few: boxes
/// that are as small as those around samples nearly, and a margin to the nearest sample.
const ENVELOPES: [usize; 5] = [1, 4, 16, 64, 1024];

/// Files of a tessellation: sampled bounds, and each number of envelopes.
pub(super) const FILES: u64 = 1 + ENVELOPES.len() as u64;

/// Pixels of the thesis's pictures.
const PICTURE_PIXELS: f64 = 1024.0 * 1024.0;

/// Rows of one tessellation.
pub(super) struct Level {
    pub bounds: Vec<BoundsFigures>,
    pub tessellations: Vec<TessellationFigures>,
    pub brute_force_rays: u64,
}

/// Ways to bound boxes at one tessellation, in poses of all kinds; and Table 3.3 from the same files.
pub(super) fn measure_tessellation(
    animation: &Animation,
    subdivisions: u32,
    round: &Round,
) -> Result<Level, MeasureError> {
    let settings = round.settings;
    let mesh = subdivide(animation, subdivisions);
    let sampled = BakeSettings {
        bounds: Bounds::Sampled,
        tree: settings.tree,
        ..BakeSettings::default()
    };
    let envelopes = ENVELOPES.map(|envelopes| BakeSettings {
        bounds: Bounds::Envelope,
        envelopes,
        tree: settings.tree,
        ..BakeSettings::default()
    });
    let mut candidates = Vec::new();
    for bake in std::iter::once(sampled).chain(envelopes) {
        candidates.push(Candidate::new(&mesh, subdivisions, &bake)?);
        round.progress.advance(1);
    }
    relate_areas(&mut candidates);
    let mut level = Level {
        bounds: Vec::new(),
        tessellations: Vec::new(),
        brute_force_rays: 0,
    };
    for kind in PoseKind::ALL {
        let poses = kind.draw(&mesh, candidates[0].asset.model(), settings.seed, settings.poses);
        let round = Round {
            kind: kind.name(),
            ..*round
        };
        let (standings, brute_force_rays) = contest(&candidates, candidates.len(), &poses, &round)?;
        level.brute_force_rays += brute_force_rays;
        round.progress.advance((settings.poses - poses.len()) as u64);
        if poses.is_empty() {
            continue;
        }
        for (candidate, standing) in candidates.iter().zip(&standings) {
            let (commits, rays) = (standing.commits(), standing.rays());
            level.bounds.extend(rays.map(|rays| BoundsFigures {
                file: candidate.file.clone(),
                poses: kind.name(),
                commits,
                rays,
            }));
            if kind == PoseKind::Clip {
                let seconds = &candidate.seconds;
                let primary = rays[0];
                level.tessellations.push(TessellationFigures {
                    file: candidate.file.clone(),
                    sampling_seconds: seconds.sample + seconds.decompose + seconds.bound,
                    tree_seconds: seconds.build,
                    commit_us: commits.commit_us,
                    frames_per_s: 1e6 / (commits.commit_us + PICTURE_PIXELS / primary.mrays_per_s),
                    rays: primary,
                });
            }
        }
    }
    Ok(level)
}
