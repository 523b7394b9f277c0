use super::row;
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClusterRow, NONE, ReferenceBoxRow},
};

/// Every reference has a box, no box is empty, and those in free motion are zero. Clusters and their tracks have been
/// checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::ReferenceBoxes;
    let (expected, found) = (view.references.len() as u64, view.reference_boxes.len() as u64);
    if expected != found {
        return Err(FormatError::RowCount {
            section,
            expected,
            found,
        });
    }
    for (at, bounds) in view.reference_boxes.iter().enumerate() {
        if let Some(axis) = (0..3).find(|axis| bounds.min[*axis] > bounds.max[*axis]) {
            let fault = RowFault::EmptyBox {
                field: "box",
                axis,
                min: f32::from(bounds.min[axis]),
                max: f32::from(bounds.max[axis]),
            };
            return Err(row(section, at, fault));
        }
    }
    for cluster in view.clusters.iter().filter(|cluster| is_free(view, cluster)) {
        let first = cluster.reference_first as usize;
        let boxes = &view.reference_boxes[first..first + cluster.reference_count as usize];
        if let Some(at) = boxes.iter().position(|bounds| *bounds != ReferenceBoxRow::default()) {
            return Err(row(section, first + at, RowFault::ReservedNotZero { field: "box" }));
        }
    }
    Ok(())
}

fn is_free(view: &ModelView<'_>, cluster: &ClusterRow) -> bool {
    cluster.track != NONE && view.tracks[cluster.track as usize].key_first == NONE
}
