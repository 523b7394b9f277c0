use super::row;
use crate::{FormatError, RowFault, SectionKind};
use std::ops::Range;

/// Ranges that must follow each other without gap or overlap and together fill a section.
pub(super) struct Tiling {
    /// The section that the ranges fill.
    filled: SectionKind,
    len: u64,
    /// Rows at the end of the section that belong to no range.
    closing: u64,
    next: u64,
}

impl Tiling {
    /// Ranges over a section of `len` rows.
    pub(super) fn new(filled: SectionKind, len: usize) -> Self {
        Self {
            filled,
            len: len as u64,
            closing: 0,
            next: 0,
        }
    }

    /// Ranges over a section of `len` rows, the last of which only closes it.
    pub(super) fn with_closing_row(filled: SectionKind, len: usize) -> Self {
        Self {
            closing: 1,
            ..Self::new(filled, len)
        }
    }

    /// Checks the next range, which row `at` of `section` gives, and returns it.
    pub(super) fn take(
        &mut self,
        section: SectionKind,
        at: usize,
        field: &'static str,
        first: u32,
        count: u32,
    ) -> Result<Range<usize>, FormatError> {
        let (first, count) = (u64::from(first), u64::from(count));
        if first != self.next {
            let fault = RowFault::RangeNotContiguous {
                field,
                found: first,
                expected: self.next,
            };
            return Err(row(section, at, fault));
        }
        let end = first + count;
        let limit = self.len.saturating_sub(self.closing);
        if end > limit {
            let fault = RowFault::RangeOutOfBounds {
                field,
                first,
                count,
                limit,
            };
            return Err(row(section, at, fault));
        }
        self.next = end;
        Ok(first as usize..end as usize)
    }

    /// Checks that the ranges fill the section.
    pub(super) fn finish(self) -> Result<(), FormatError> {
        let expected = self.next + self.closing;
        if expected == self.len {
            Ok(())
        } else {
            Err(FormatError::RowCount {
                section: self.filled,
                expected,
                found: self.len,
            })
        }
    }
}
