use super::{
    numbers::{extent, solid_box},
    row,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{ClipBoundsRow, STRETCHES},
};

/// There are bounds of every stretch of every clip and of the pose without any, or of none; known ones are boxes with
/// their magnitudes, others are empty.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::ClipBounds;
    check_count(view)?;
    for (at, stretch) in view.clip_bounds.iter().enumerate() {
        match stretch.known {
            0 if *stretch == ClipBoundsRow::UNKNOWN => {}
            0 => return Err(row(section, at, RowFault::UnknownBounds)),
            1 => {
                solid_box(section, at, "bounds", &stretch.bounds)?;
                extent(section, at, "reach", &stretch.reach)?;
                extent(section, at, "rest_reach", &[stretch.rest_reach])?;
            }
            found => {
                let (field, limit) = ("known", 2);
                return Err(row(section, at, RowFault::UnknownNumber { field, found, limit }));
            }
        }
    }
    Ok(())
}

/// The number of rows alone, which tells files of before there were stretches.
pub(crate) fn check_count(view: &ModelView<'_>) -> Result<(), FormatError> {
    let found = view.clip_bounds.len() as u64;
    let expected = view.clips.len() as u64 * STRETCHES as u64 + 1;
    if found == 0 || found == expected {
        return Ok(());
    }
    Err(FormatError::RowCount {
        section: SectionKind::ClipBounds,
        expected,
        found,
    })
}
