use super::{
    numbers::{reserved, solid_box},
    row,
};
use crate::{FormatError, ModelView, RowFault, SectionKind, geom::Aabb};

/// There are bounds of every clip and of the pose without any, or of none; known ones are boxes, others are empty.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::ClipBounds;
    let (found, expected) = (view.clip_bounds.len(), view.clips.len() + 1);
    if found != 0 && found != expected {
        return Err(FormatError::RowCount {
            section,
            expected: expected as u64,
            found: found as u64,
        });
    }
    for (at, clip) in view.clip_bounds.iter().enumerate() {
        reserved(section, at, "reserved", &[clip.reserved])?;
        match clip.known {
            0 if clip.bounds == Aabb::EMPTY => {}
            0 => return Err(row(section, at, RowFault::UnknownBounds)),
            1 => solid_box(section, at, "bounds", &clip.bounds)?,
            found => {
                let (field, limit) = ("known", 2);
                return Err(row(section, at, RowFault::UnknownNumber { field, found, limit }));
            }
        }
    }
    Ok(())
}
