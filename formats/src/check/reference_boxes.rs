use super::row;
use crate::{FormatError, ModelView, RowFault, SectionKind};

/// Every reference has a box, and no box is empty.
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
    Ok(())
}
