use super::{
    numbers::{finite, index_within, reserved},
    row,
    segments::{self, Segment},
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{KeyVertexRow, NONE},
};

/// Key vertices have tracks of their segment and numbers that `f32` can hold; their records tile the bits of a key. Segments and
/// tracks have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    for segment in segments::all(view) {
        let mut bits = 0u64;
        for at in segment.key_vertices() {
            let vertex = &view.key_vertices[at];
            check_fields(view, &segment, at, vertex)?;
            if u64::from(vertex.bit_first) != bits {
                let (field, found) = ("bit_first", vertex.bit_first.into());
                let fault = RowFault::RangeNotContiguous {
                    field,
                    found,
                    expected: bits,
                };
                return Err(row(SectionKind::KeyVertices, at, fault));
            }
            bits += u64::from(vertex.record_bits());
        }
        let (found, expected) = (u64::from(segment.row.words_per_key), bits.div_ceil(32));
        if found != expected {
            let field = "words_per_key";
            return Err(row(
                SectionKind::Segments,
                segment.at,
                RowFault::Count { field, found, expected },
            ));
        }
        check_words(view, &segment, bits)?;
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

/// Raw positions are finite; behind the last of a key's records, which have so many bits, there are none.
fn check_words(view: &ModelView<'_>, segment: &Segment<'_>, bits: u64) -> Result<(), FormatError> {
    // Of keys without words there may be any number in any file.
    if bits == 0 {
        return Ok(());
    }
    let is_raw = |at: &usize| view.key_vertices[*at].raw != 0;
    let raw: Vec<usize> = segment.key_vertices().filter(is_raw).collect();
    for (key, words) in (0..).zip(segment.keys(view)) {
        let first = segment.row.first_word(key);
        for at in &raw {
            let vertex = &view.key_vertices[*at];
            let position = vertex.stored(words);
            finite(SectionKind::KeyWords, first + vertex.word(), "position", &position)?;
        }
        if !bits.is_multiple_of(32) {
            let last = (bits / 32) as usize;
            let unused = words[last] >> (bits % 32);
            reserved(
                SectionKind::KeyWords,
                first + last,
                "bits behind the last record",
                &[unused],
            )?;
        }
    }
    Ok(())
}
