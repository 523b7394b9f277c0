use super::{
    numbers::{finite, index_within, reserved},
    row,
    segments::{self, Segment},
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{KeyVertexRow, NONE},
};
use std::ops::Range;

/// Key vertices have tracks of their segment and numbers that `f32` can hold; their records tile the words but for those
/// that close the section. Segments and tracks have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let closing = if view.caches.is_empty() {
        0
    } else {
        KeyVertexRow::CLOSING_WORDS
    };
    let mut words = Tiling::with_closing_rows(SectionKind::KeyWords, view.key_words.len(), closing);
    for segment in segments::all(view) {
        for at in segment.key_vertices() {
            let vertex = &view.key_vertices[at];
            check_fields(view, &segment, at, vertex)?;
            let count = vertex.word_count(segment.row.key_count);
            let range = words.take(SectionKind::KeyVertices, at, "word_first", vertex.word_first, count)?;
            check_words(view, &segment, vertex, range)?;
        }
    }
    words.finish()?;
    let first = view.key_words.len() - closing;
    for (at, word) in view.key_words.iter().enumerate().skip(first) {
        reserved(SectionKind::KeyWords, at, "closing word", &[*word])?;
    }
    Ok(())
}

fn check_fields(
    view: &ModelView<'_>,
    segment: &Segment<'_>,
    at: usize,
    vertex: &KeyVertexRow,
) -> Result<(), FormatError> {
    let section = SectionKind::KeyVertices;
    let fail = |fault| Err(row(section, at, fault));
    let track = index_within(section, at, "track", vertex.track, &segment.tracks())?;
    match vertex.raw {
        0 => {}
        1 => {
            if view.tracks[track].key_first != NONE {
                return fail(RowFault::RawOnTrackWithKeys { track: vertex.track });
            }
            reserved(section, at, "base", &vertex.base.map(|base| base as u32))?;
            return reserved(section, at, "widths", &vertex.widths.map(u32::from));
        }
        found => {
            let (field, found, limit) = ("raw", u32::from(found), 2);
            return fail(RowFault::UnknownNumber { field, found, limit });
        }
    }
    for axis in 0..3 {
        let (found, limit) = (vertex.widths[axis], KeyVertexRow::MAX_WIDTH);
        if found > limit {
            return fail(RowFault::TooWide { axis, found, limit });
        }
        let limit = KeyVertexRow::MAX_COORDINATE;
        for found in vertex.lattice_range(axis) {
            if found.unsigned_abs() > u64::from(limit.unsigned_abs()) {
                return fail(RowFault::BeyondLattice { axis, found, limit });
            }
        }
    }
    Ok(())
}

/// Raw positions are finite; behind the last record there are no bits.
fn check_words(
    view: &ModelView<'_>,
    segment: &Segment<'_>,
    vertex: &KeyVertexRow,
    range: Range<usize>,
) -> Result<(), FormatError> {
    let section = SectionKind::KeyWords;
    if vertex.raw != 0 {
        for at in range {
            finite(section, at, "position", &[f32::from_bits(view.key_words[at])])?;
        }
        return Ok(());
    }
    let bits = u64::from(vertex.record_bits()) * u64::from(segment.row.key_count);
    match range.last() {
        Some(last) if bits % 32 != 0 => {
            let unused = view.key_words[last] >> (bits % 32);
            reserved(section, last, "bits behind the last record", &[unused])
        }
        _ => Ok(()),
    }
}
