use super::{cluster_bones::Cover, numbers::index, row};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, NONE, TriangleRow},
};

/// Every triangle with area belongs to exactly one cluster, a degenerate one to none, and a cluster lists the bones
/// that move its vertices. Clusters' ranges and everything about triangles and vertices have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut owners = vec![NONE; view.triangles.len()];
    let mut cover = Cover::new(view);
    for (at, cluster) in view.clusters.iter().enumerate() {
        cover.enter(at, cluster)?;
        let found = claim(view, at, cluster, &mut owners, &mut cover)?;
        cover.leave(cluster)?;
        if found != u64::from(cluster.triangle_count) {
            let fault = RowFault::Count {
                field: "triangle_count",
                found: u64::from(cluster.triangle_count),
                expected: found,
            };
            return Err(row(SectionKind::Clusters, at, fault));
        }
    }
    let mut degenerate = 0;
    for (at, (triangle, owner)) in view.triangles.iter().zip(&owners).enumerate() {
        if is_degenerate(triangle) {
            degenerate += 1;
        } else if *owner == NONE {
            return Err(row(SectionKind::Triangles, at, RowFault::TriangleInNoCluster));
        }
    }
    let found = u64::from(view.meta.degenerate_triangle_count);
    if found == degenerate {
        Ok(())
    } else {
        Err(FormatError::DegenerateTriangleCount {
            expected: degenerate,
            found,
        })
    }
}

/// Gives the referenced triangles to cluster `at` and returns how many they are.
fn claim(
    view: &ModelView<'_>,
    at: usize,
    cluster: &ClusterRow,
    owners: &mut [u32],
    cover: &mut Cover<'_>,
) -> Result<u64, FormatError> {
    let section = SectionKind::References;
    let first = cluster.reference_first as usize;
    let mut claimed = 0;
    for reference in first..first + cluster.reference_count as usize {
        let triangle = view.references[reference];
        let index = index(section, reference, "triangle", triangle, view.triangles.len())?;
        let owner = owners[index];
        if owner == at as u32 {
            continue;
        }
        if owner != NONE {
            let fault = RowFault::TriangleInTwoClusters { triangle, other: owner };
            return Err(row(section, reference, fault));
        }
        if is_degenerate(&view.triangles[index]) {
            let fault = RowFault::DegenerateReferenced { triangle };
            return Err(row(section, reference, fault));
        }
        owners[index] = at as u32;
        claimed += 1;
        cover.triangle(&view.triangles[index])?;
    }
    Ok(claimed)
}

/// True when all corners are one vertex, the sign of a triangle without area in any pose.
fn is_degenerate(triangle: &TriangleRow) -> bool {
    let [a, b, c] = triangle.corners;
    a == b && b == c
}
