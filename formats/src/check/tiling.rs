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

    /// Ranges over a section of `len` rows, the last `closing` of which only close it.
    pub(super) fn with_closing_rows(filled: SectionKind, len: usize, closing: usize) -> Self {
        Self {
            closing: closing as u64,
            ..Self::new(filled, len)
        }
    }

    /// Ranges over a section of `len` rows from row `first` on; those before it are not theirs.
    pub(super) fn starting_at(filled: SectionKind, len: usize, first: usize) -> Self {
        Self {
            next: first as u64,
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
        count: impl Into<u64>,
    ) -> Result<Range<usize>, FormatError> {
        let (first, count) = (u64::from(first), count.into());
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
