//! Motion of a mesh whose vertices are given key by key: which triangles move together, and how.
//!
//! Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.3.

mod axes;
mod coarse;
mod components;
mod exchange;
mod fit;
mod frames;
mod fuzzy;
mod grow;
mod jacobi;
mod members;
mod patch;
mod refine;
mod relax;
mod report;
mod residual;
mod rest;
mod rigid;
#[cfg(test)]
mod scenes;
mod settings;
mod states;
#[cfg(test)]
mod tests;
mod tracks;

pub use report::DecomposeReport;
pub use settings::DecomposeSettings;

use crate::Progress;
use components::Components;
use members::Members;
use refine::Refined;
use restpose_formats::geom::Affine;
use rigid::{Rigidity, sort_components};
use states::States;
use std::time::Instant;

/// Key frames of one mesh.
pub(crate) struct KeyFrames<'a> {
    /// Per key, positions of all points, part space; finite, up to 1e30 in magnitude. At least one.
    pub frames: Vec<&'a [[f32; 3]]>,
    /// Corners of every triangle, as points.
    pub triangles: &'a [[u32; 3]],
}

/// How the triangles of a cluster move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TrackKind {
    /// Not at all.
    Static,
    /// As the cluster's maps say, within the rigid tolerance.
    Rigid,
    /// As the cluster's maps say, and a little besides.
    Coherent,
}

/// A cluster and its motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClusterTrack {
    /// How its triangles move.
    pub kind: TrackKind,
    /// Part space from local space, one per key, rounded to what a file holds.
    ///
    /// Guarantee: each is accepted by [`restpose_runtime::invert_frame`]; for coherent clusters its singular values are
    /// within [`fit::STRETCH_LIMIT`] of one scale and its determinant is positive.
    pub from_local: Vec<Affine>,
}

/// A mesh decomposed into clusters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Decomposition {
    /// Static one first, then rigid ones by falling surface, then coherent ones; each has triangles.
    pub clusters: Vec<ClusterTrack>,
    /// Per triangle.
    pub cluster_of: Vec<u32>,
    /// Key whose points are the rest pose of the clustering.
    pub rest_key: usize,
    /// How it went.
    pub report: DecomposeReport,
}

/// Decomposes the motion of a mesh: components that stand still or move by one map per key are taken out, the other
/// triangles are clustered by their motion, and each cluster gets an affine map per key.
///
/// Deterministic: the same bytes on any number of threads.
///
/// `progress` gets a stage that advances by one per number of clusters tried, and one that does so per cluster moved.
pub(crate) fn decompose_keys(keys: &KeyFrames, settings: &DecomposeSettings, progress: &dyn Progress) -> Decomposition {
    progress.stage("clusters", settings.max_clusters as u64);
    let begin = Instant::now();
    let mesh = Components::new(keys);
    let sorted = sort_components(keys, &mesh, settings);
    let mut out = take_out(keys, &mesh, &sorted);
    let states = states_of(keys, &mesh, &sorted.coherent);
    out.report.seconds.components = begin.elapsed().as_secs_f64();
    if !states.triangles.is_empty() {
        cluster(&states, &mesh, &sorted, settings, progress, &mut out);
    }
    out
}

/// The static and rigid clusters.
fn take_out(keys: &KeyFrames, mesh: &Components, sorted: &Rigidity) -> Decomposition {
    let mut out = Decomposition {
        clusters: Vec::new(),
        cluster_of: vec![0; keys.triangles.len()],
        rest_key: 0,
        report: DecomposeReport::default(),
    };
    let report = &mut out.report;
    report.static_components = sorted.still.len();
    report.rigid_clusters = sorted.rigid.len();
    let still = ClusterTrack {
        kind: TrackKind::Static,
        from_local: vec![Affine::IDENTITY; keys.frames.len()],
    };
    let still = (!sorted.still.is_empty()).then_some((still, &sorted.still));
    let rigid = sorted.rigid.iter().map(|cluster| {
        let track = ClusterTrack {
            kind: TrackKind::Rigid,
            from_local: cluster.from_local.clone(),
        };
        (track, &cluster.components)
    });
    for (track, components) in still.into_iter().chain(rigid) {
        let triangles = components
            .iter()
            .flat_map(|component| &mesh.components[*component as usize].triangles);
        let mut count = 0;
        for triangle in triangles {
            out.cluster_of[*triangle as usize] = out.clusters.len() as u32;
            count += 1;
        }
        if track.kind == TrackKind::Static {
            report.static_triangles = count;
        } else {
            report.rigid_components += components.len();
            report.rigid_triangles += count;
        }
        out.clusters.push(track);
    }
    out
}

/// What is left to cluster.
fn states_of(keys: &KeyFrames, mesh: &Components, coherent: &[u32]) -> States {
    let components = || coherent.iter().map(|component| &mesh.components[*component as usize]);
    let mut points: Vec<u32> = components()
        .flat_map(|component| component.points.iter().copied())
        .collect();
    points.sort_unstable();
    let renumber = |point: u32| points.partition_point(|other| *other < point) as u32;
    let triangles = components()
        .flat_map(|component| &component.triangles)
        .map(|triangle| mesh.triangles[*triangle as usize].map(renumber))
        .collect();
    States::new(&keys.frames, &points, triangles)
}

fn cluster(
    states: &States,
    mesh: &Components,
    sorted: &Rigidity,
    settings: &DecomposeSettings,
    progress: &dyn Progress,
    out: &mut Decomposition,
) {
    let most = settings.max_clusters.saturating_sub(out.clusters.len()).max(1);
    let begin = Instant::now();
    let coarse = coarse::coarse(states);
    out.report.seconds.coarse = begin.elapsed().as_secs_f64();
    let searched = coarse.as_ref().unwrap_or(states);
    let report = &mut out.report;
    report.searched_triangles = searched.triangles.len();
    let (mut refined, rest_key) = search(searched, most, settings, progress, report);
    if coarse.is_some() {
        let begin = Instant::now();
        refined = refine::settle_again(states, refined.tracks, refined.tiers);
        report.seconds.refine += begin.elapsed().as_secs_f64();
    }
    report.ideal_cost = states.ideal_costs().iter().sum::<f64>() * states.unit * states.unit;
    report.cost = refined.cost * states.unit * states.unit;
    report.tiers = refined.tiers;
    out.rest_key = rest_key;

    let members = Members::of_clusters(states, &refined.cluster_of, refined.tracks.len());
    let triangles = sorted
        .coherent
        .iter()
        .flat_map(|component| &mesh.components[*component as usize].triangles);
    let triangles: Vec<u32> = triangles.copied().collect();
    for (members, track) in members
        .iter()
        .zip(&refined.tracks)
        .filter(|(members, _)| !members.triangles.is_empty())
    {
        for triangle in &members.triangles {
            out.cluster_of[triangles[*triangle as usize] as usize] = out.clusters.len() as u32;
        }
        out.clusters.push(ClusterTrack {
            kind: TrackKind::Coherent,
            from_local: frames::frames_of(states, members, track, rest_key),
        });
    }
}

/// Looks for the clusters; with the key whose points are their rest pose.
fn search(
    states: &States,
    most: usize,
    settings: &DecomposeSettings,
    progress: &dyn Progress,
    report: &mut DecomposeReport,
) -> (Refined, usize) {
    let begin = Instant::now();
    let grown = grow::grow(states, most, settings, progress);
    let after_grow = Instant::now();
    report.seconds.rest = grown.rest_seconds;
    report.seconds.relax = (after_grow - begin).as_secs_f64() - grown.rest_seconds;
    report.rest_key = grown.rest_key;
    report.rest_candidates = grown.rest_candidates;
    report.least_squares_cost = grown.steps.last().map_or(0.0, |step| step.cost);
    report.steps = grown.steps;
    report.stop = grown.stop;

    progress.stage("refine clusters", grown.clustering.clusters() as u64);
    let mut refined = refine::refine(states, grown.clustering.tracks, grown.clustering.tiers);
    let mut axes_seconds = 0.0;
    let mut turn_axes = |refined: &mut Refined, search: bool| {
        let begin = Instant::now();
        let turned = if settings.principal_axes {
            axes::turn_axes(states, refined, search)
        } else {
            Vec::new()
        };
        axes_seconds += begin.elapsed().as_secs_f64();
        turned
    };
    turn_axes(&mut refined, false);
    let turn = &mut |refined: &mut Refined| {
        turn_axes(refined, false);
    };
    refined = exchange::exchange(states, refined, grown.rest_key, turn, progress);
    let turned = turn_axes(&mut refined, true);
    refined = refine::refine(states, refined.tracks, refined.tiers);
    report.seconds.refine = after_grow.elapsed().as_secs_f64() - axes_seconds;
    report.seconds.axes = axes_seconds;
    report.turned_clusters = turned.iter().filter(|turned| **turned).count();
    (refined, grown.rest_key)
}
