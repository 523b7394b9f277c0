use super::row;
use crate::{FormatError, RowFault, SectionKind, geom::Aabb};
use std::ops::Range;

/// Every value is finite.
pub(super) fn finite(section: SectionKind, at: usize, field: &'static str, values: &[f32]) -> Result<(), FormatError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(found) => Err(row(section, at, RowFault::NotFinite { field, found: *found })),
        None => Ok(()),
    }
}

/// Every value is finite and not below zero.
pub(super) fn extent(section: SectionKind, at: usize, field: &'static str, values: &[f32]) -> Result<(), FormatError> {
    finite(section, at, field, values)?;
    match values.iter().find(|value| **value < 0.0) {
        Some(found) => Err(row(section, at, RowFault::Negative { field, found: *found })),
        None => Ok(()),
    }
}

/// A box is finite and holds a point.
pub(super) fn solid_box(
    section: SectionKind,
    at: usize,
    field: &'static str,
    bounds: &Aabb,
) -> Result<(), FormatError> {
    finite(section, at, field, &bounds.min)?;
    finite(section, at, field, &bounds.max)?;
    for axis in 0..3 {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        if min > max {
            return Err(row(section, at, RowFault::EmptyBox { field, axis, min, max }));
        }
    }
    Ok(())
}

/// No value is larger than the extent of its axis, which row `extent_row` gives.
pub(super) fn within_extent(
    section: SectionKind,
    at: usize,
    field: &'static str,
    values: [f32; 3],
    extent: [f32; 3],
    extent_row: usize,
) -> Result<(), FormatError> {
    for axis in 0..3 {
        if values[axis].abs() > extent[axis] {
            let fault = RowFault::BeyondExtent {
                field,
                axis,
                found: values[axis],
                extent: extent[axis],
                extent_row: extent_row as u64,
            };
            return Err(row(section, at, fault));
        }
    }
    Ok(())
}

/// Every value lies in the box that row `box_row` gives.
pub(super) fn within_box(
    section: SectionKind,
    at: usize,
    field: &'static str,
    values: [f32; 3],
    bounds: &Aabb,
    box_row: usize,
) -> Result<(), FormatError> {
    for axis in 0..3 {
        let (found, min, max) = (values[axis], bounds.min[axis], bounds.max[axis]);
        if found < min || found > max {
            let fault = RowFault::OutsideBox {
                field,
                axis,
                found,
                min,
                max,
                box_row: box_row as u64,
            };
            return Err(row(section, at, fault));
        }
    }
    Ok(())
}

/// A reserved place is zero, bit for bit.
pub(super) fn reserved(section: SectionKind, at: usize, field: &'static str, words: &[u32]) -> Result<(), FormatError> {
    if words.iter().all(|word| *word == 0) {
        Ok(())
    } else {
        Err(row(section, at, RowFault::ReservedNotZero { field }))
    }
}

/// An index is below `limit`.
pub(super) fn index(
    section: SectionKind,
    at: usize,
    field: &'static str,
    found: u32,
    limit: usize,
) -> Result<usize, FormatError> {
    if (found as usize) < limit {
        Ok(found as usize)
    } else {
        let fault = RowFault::IndexOutOfRange {
            field,
            found: u64::from(found),
            limit: limit as u64,
        };
        Err(row(section, at, fault))
    }
}

/// An index lies in `range`.
pub(super) fn index_within(
    section: SectionKind,
    at: usize,
    field: &'static str,
    found: u32,
    range: &Range<usize>,
) -> Result<usize, FormatError> {
    if range.contains(&(found as usize)) {
        Ok(found as usize)
    } else {
        let fault = RowFault::IndexOutsideRange {
            field,
            found: u64::from(found),
            first: range.start as u64,
            limit: range.end as u64,
        };
        Err(row(section, at, fault))
    }
}
