use super::{
    cluster_bones::Cover,
    numbers::{index, index_within},
    row,
    segments::{self, Segment},
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, NONE, TriangleRow},
};
use std::ops::Range;

/// Every triangle with area belongs to exactly one cluster, that of a part with a cache to one in each of the cache's
/// segments, a degenerate one to none; and a cluster lists the bones or tracks, and in a pose space the morph targets,
/// that move its vertices. Everything else has been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut claims = Claims {
        view,
        cached: vec![false; view.triangles.len()],
        owners: vec![NONE; view.triangles.len()],
        cover: Cover::new(view),
    };
    for cache in view.caches {
        claims.cached[triangles_of(view, cache.part)].fill(true);
    }
    claims.claim_without_track()?;
    for cache in view.caches {
        let triangles = triangles_of(view, cache.part);
        let expected = view.triangles[triangles.clone()]
            .iter()
            .filter(|triangle| !is_degenerate(triangle));
        let expected = expected.count() as u64;
        for segment in segments::of_cache(view, cache) {
            claims.claim_in_segment(&segment, &triangles, expected)?;
        }
    }
    let expected = view.triangles.iter().filter(|triangle| is_degenerate(triangle)).count() as u64;
    let found = u64::from(view.meta.degenerate_triangle_count);
    if found == expected {
        Ok(())
    } else {
        Err(FormatError::DegenerateTriangleCount { expected, found })
    }
}

fn triangles_of(view: &ModelView<'_>, part: u32) -> Range<usize> {
    let part = &view.parts[part as usize];
    part.triangle_first as usize..part.triangle_first as usize + part.triangle_count as usize
}

/// Which cluster each triangle belongs to.
struct Claims<'a> {
    view: &'a ModelView<'a>,
    /// Per triangle, whether its part has a cache.
    cached: Vec<bool>,
    /// Per triangle, the last cluster that claimed it, or `NONE`.
    owners: Vec<u32>,
    cover: Cover<'a>,
}

impl Claims<'_> {
    /// The clusters without a track share out the triangles without a cache.
    fn claim_without_track(&mut self) -> Result<(), FormatError> {
        let clusters = 0..segments::clusters_without_track(self.view);
        for at in clusters.clone() {
            self.claim(at, None, &clusters)?;
        }
        let triangles = 0..self.view.triangles.len();
        match self.first_unclaimed(triangles, &clusters, |at| !self.cached[at]) {
            Some(at) => Err(row(SectionKind::Triangles, at, RowFault::TriangleInNoCluster)),
            None => Ok(()),
        }
    }

    /// A segment's clusters share out the triangles of its part, of which `expected` have area.
    fn claim_in_segment(
        &mut self,
        segment: &Segment<'_>,
        triangles: &Range<usize>,
        expected: u64,
    ) -> Result<(), FormatError> {
        let clusters = segment.clusters();
        let mut claimed = 0;
        for at in clusters.clone() {
            claimed += self.claim(at, Some((segment, triangles)), &clusters)?;
        }
        if claimed == expected {
            return Ok(());
        }
        // Looked for only here: a segment that claims all is not to cost as much as its part has triangles.
        match self.first_unclaimed(triangles.clone(), &clusters, |_| true) {
            Some(at) => {
                let segment = segment.at as u32;
                Err(row(
                    SectionKind::Triangles,
                    at,
                    RowFault::TriangleNotInSegment { segment },
                ))
            }
            None => Ok(()),
        }
    }

    /// The first triangle with area that is `wanted` and belongs to none of the clusters.
    fn first_unclaimed(
        &self,
        mut triangles: Range<usize>,
        clusters: &Range<usize>,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        triangles.find(|at| {
            let claimed = clusters.contains(&(self.owners[*at] as usize));
            wanted(*at) && !claimed && !is_degenerate(&self.view.triangles[*at])
        })
    }

    /// Gives the referenced triangles to cluster `at`, one of `clusters`, and returns how many they are.
    fn claim(
        &mut self,
        at: usize,
        segment: Option<(&Segment<'_>, &Range<usize>)>,
        clusters: &Range<usize>,
    ) -> Result<u64, FormatError> {
        let view = self.view;
        let cluster = &view.clusters[at];
        self.cover.enter(at, cluster, segment.map(|(segment, _)| segment))?;
        let section = SectionKind::References;
        let first = cluster.reference_first as usize;
        let mut claimed = 0;
        for reference in first..first + cluster.reference_count as usize {
            let triangle = view.references[reference];
            let fail = |fault| Err(row(section, reference, fault));
            let index = match segment {
                None => index(section, reference, "triangle", triangle, view.triangles.len())?,
                Some((_, triangles)) => index_within(section, reference, "triangle", triangle, triangles)?,
            };
            let owner = self.owners[index];
            if owner == at as u32 {
                continue;
            }
            if segment.is_none() && self.cached[index] {
                return fail(RowFault::TriangleNeedsTrack { triangle });
            }
            if clusters.contains(&(owner as usize)) {
                return fail(RowFault::TriangleInTwoClusters { triangle, other: owner });
            }
            if is_degenerate(&view.triangles[index]) {
                return fail(RowFault::DegenerateReferenced { triangle });
            }
            self.owners[index] = at as u32;
            claimed += 1;
            self.cover
                .triangle(&view.triangles[index], segment.map(|(segment, _)| segment))?;
        }
        self.cover.leave(cluster)?;
        check_count(at, cluster, claimed)?;
        Ok(claimed)
    }
}

fn check_count(at: usize, cluster: &ClusterRow, expected: u64) -> Result<(), FormatError> {
    let (field, found) = ("triangle_count", u64::from(cluster.triangle_count));
    if found == expected {
        return Ok(());
    }
    Err(row(
        SectionKind::Clusters,
        at,
        RowFault::Count { field, found, expected },
    ))
}

/// True when all corners are one vertex, the sign of a triangle without area in any pose.
fn is_degenerate(triangle: &TriangleRow) -> bool {
    let [a, b, c] = triangle.corners;
    a == b && b == c
}
