use super::{
    numbers::index_within,
    row,
    segments::{self, Segment},
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, NONE},
};

/// The clusters of a segment have tracks of it and its cache's bone; each track with keys moves one cluster and has a
/// tree; a cluster in free motion has none. Clusters' ranges, segments and tracks have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    // Per track with keys, the cluster that it moves.
    let mut moved = vec![NONE; view.tracks.len()];
    for segment in segments::all(view) {
        for at in segment.clusters() {
            let cluster = &view.clusters[at];
            let track = check_cluster(&segment, at, cluster)?;
            if view.tracks[track].key_first == NONE {
                check_free(at, cluster)?;
                continue;
            }
            if cluster.node_count == 0 {
                return Err(row(
                    SectionKind::Clusters,
                    at,
                    RowFault::EmptyRange { field: "node_count" },
                ));
            }
            let other = std::mem::replace(&mut moved[track], at as u32);
            if other != NONE {
                let fault = RowFault::TrackShared {
                    track: cluster.track,
                    other,
                };
                return Err(row(SectionKind::Clusters, at, fault));
            }
        }
    }
    let unused = moved.iter().zip(view.tracks);
    let unused = unused
        .enumerate()
        .find(|(_, (moved, track))| **moved == NONE && track.key_first != NONE);
    match unused {
        Some((at, _)) => Err(row(SectionKind::Tracks, at, RowFault::TrackUnused)),
        None => Ok(()),
    }
}

/// Returns the track.
fn check_cluster(segment: &Segment<'_>, at: usize, cluster: &ClusterRow) -> Result<usize, FormatError> {
    let section = SectionKind::Clusters;
    let track = index_within(section, at, "track", cluster.track, &segment.tracks())?;
    if cluster.bone == segment.cache.bone {
        return Ok(track);
    }
    let (found, expected) = (cluster.bone, segment.cache.bone);
    Err(row(section, at, RowFault::NotTheCachesBone { found, expected }))
}

/// No nodes, and as many references as triangles. Whether the triangles are distinct is checked with all clusters.
fn check_free(at: usize, cluster: &ClusterRow) -> Result<(), FormatError> {
    let counts = [
        ("node_count", cluster.node_count, 0),
        ("reference_count", cluster.reference_count, cluster.triangle_count),
    ];
    match counts.into_iter().find(|(_, found, expected)| found != expected) {
        Some((field, found, expected)) => {
            let (found, expected) = (u64::from(found), u64::from(expected));
            Err(row(
                SectionKind::Clusters,
                at,
                RowFault::Count { field, found, expected },
            ))
        }
        None => Ok(()),
    }
}
