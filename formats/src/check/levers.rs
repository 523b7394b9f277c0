use super::{
    cluster_bones,
    numbers::{extent, finite, reserved},
    row,
};
use crate::{FormatError, ModelView, RowFault, SectionKind, rows::LeverRow};

/// Levers are finite and not negative, weights at most one, and a cluster has no lever against its own bone. Pose spaces
/// have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::Levers;
    for (cluster, _) in view.clusters.iter().zip(view.pose_spaces) {
        for at in cluster_bones::rows_of(cluster) {
            let LeverRow {
                pivot,
                lever,
                weight,
                reserved: unused,
            } = &view.levers[at];
            if view.cluster_bones[at].bone == cluster.bone {
                let words: &[u32; 8] = bytemuck::cast_ref(&view.levers[at]);
                reserved(section, at, "lever of the cluster's own bone", words)?;
                continue;
            }
            reserved(section, at, "reserved", &[*unused])?;
            finite(section, at, "pivot", pivot)?;
            extent(section, at, "lever", lever)?;
            extent(section, at, "weight", &[*weight])?;
            if *weight > 1.0 {
                let (field, found) = ("weight", *weight);
                return Err(row(section, at, RowFault::AboveOne { field, found }));
            }
        }
    }
    Ok(())
}

/// The lever of row `at` reaches a vertex that its bone moves with `weight`.
pub(super) fn check_reach(view: &ModelView<'_>, at: usize, vertex: usize, weight: f32) -> Result<(), FormatError> {
    let lever = &view.levers[at];
    let arm = lever.arm(view.vertices[vertex].position_rest, weight);
    let needed = [
        ("lever[0]", lever.lever[0], arm[0]),
        ("lever[1]", lever.lever[1], arm[1]),
        ("lever[2]", lever.lever[2], arm[2]),
        ("weight", lever.weight, f64::from(weight)),
    ];
    for (field, found, least) in needed {
        if least > f64::from(found) {
            let vertex = vertex as u32;
            let fault = RowFault::TooSmall {
                field,
                found,
                least,
                vertex,
            };
            return Err(row(SectionKind::Levers, at, fault));
        }
    }
    Ok(())
}
