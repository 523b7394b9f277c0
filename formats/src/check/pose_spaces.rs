use super::{cluster_bones, numbers::reserved, row, segments, tiling::Tiling};
use crate::{Bounds, FormatError, ModelView, RowFault, SectionKind};

/// Where the boxes bound envelopes, every cluster without a track has a pose space, and these tile the rows of morphs and
/// envelopes; every bone of such a cluster has a lever. Where the boxes bound samples, there are none of all these.
/// Clusters have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    match view.meta.bounds {
        Bounds::Sampled => check_absent(view),
        Bounds::Envelope => {
            check_counts(view)?;
            check_ranges(view)
        }
    }
}

fn check_absent(view: &ModelView<'_>) -> Result<(), FormatError> {
    let counts = [
        (SectionKind::PoseSpaces, view.pose_spaces.len()),
        (SectionKind::Levers, view.levers.len()),
        (SectionKind::ClusterMorphs, view.cluster_morphs.len()),
        (SectionKind::BoneEnvelopes, view.bone_envelopes.len()),
        (SectionKind::MorphEnvelopes, view.morph_envelopes.len()),
    ];
    match counts.into_iter().find(|(_, count)| *count != 0) {
        Some((section, found)) => Err(FormatError::RowsOfSampledBounds {
            section,
            found: found as u64,
        }),
        None => Ok(()),
    }
}

/// Clusters without a track stand before all others, and so do their cluster bones.
fn check_counts(view: &ModelView<'_>) -> Result<(), FormatError> {
    let clusters = &view.clusters[..segments::clusters_without_track(view)];
    let bones = clusters.last().map_or(0, |last| cluster_bones::rows_of(last).end);
    let counts = [
        (SectionKind::PoseSpaces, clusters.len(), view.pose_spaces.len()),
        (SectionKind::Levers, bones, view.levers.len()),
    ];
    match counts.into_iter().find(|(_, expected, found)| expected != found) {
        Some((section, expected, found)) => Err(FormatError::RowCount {
            section,
            expected: expected as u64,
            found: found as u64,
        }),
        None => Ok(()),
    }
}

fn check_ranges(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::PoseSpaces;
    let mut morphs = Tiling::new(SectionKind::ClusterMorphs, view.cluster_morphs.len());
    let mut bone_envelopes = Tiling::new(SectionKind::BoneEnvelopes, view.bone_envelopes.len());
    let mut morph_envelopes = Tiling::new(SectionKind::MorphEnvelopes, view.morph_envelopes.len());
    for (at, (space, cluster)) in view.pose_spaces.iter().zip(view.clusters).enumerate() {
        reserved(section, at, "reserved", &space.reserved)?;
        if space.clips_inside > 1 {
            let (field, found, limit) = ("clips_inside", space.clips_inside, 2);
            return Err(row(section, at, RowFault::UnknownNumber { field, found, limit }));
        }
        if space.envelope_count == 0 {
            let field = "envelope_count";
            return Err(row(section, at, RowFault::EmptyRange { field }));
        }
        let bones = &view.cluster_bones[cluster_bones::rows_of(cluster)];
        let others = bones.iter().filter(|listed| listed.bone != cluster.bone).count();
        if others == 0 && space.morph_count == 0 && space.envelope_count != 1 {
            // Without rows nothing else would limit the envelopes that a reader goes through.
            let (field, found, expected) = ("envelope_count", u64::from(space.envelope_count), 1);
            return Err(row(section, at, RowFault::Count { field, found, expected }));
        }
        // A product of two numbers of 32 bits fits 64, and so does its sum with a third.
        let envelopes = u64::from(space.envelope_count);
        let bone_rows = envelopes * others as u64;
        let morph_rows = envelopes * u64::from(space.morph_count);
        morphs.take(section, at, "morph_first", space.morph_first, space.morph_count)?;
        bone_envelopes.take(section, at, "bone_envelope_first", space.bone_envelope_first, bone_rows)?;
        morph_envelopes.take(
            section,
            at,
            "morph_envelope_first",
            space.morph_envelope_first,
            morph_rows,
        )?;
    }
    morphs.finish()?;
    bone_envelopes.finish()?;
    morph_envelopes.finish()
}
