use super::{
    numbers::{finite, reserved, solid_box},
    row,
    segments::{self, Segment},
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{KeyRow, NONE, TrackRow},
};

/// Tracks have lattices, those with keys one key row per key of their segment. Segments have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut keys = Tiling::new(SectionKind::Keys, view.keys.len());
    for segment in segments::all(view) {
        for at in segment.tracks() {
            let track = &view.tracks[at];
            check_lattice(at, track)?;
            if track.key_first != NONE {
                check_keys(view, &segment, at, &mut keys)?;
            }
        }
    }
    keys.finish()
}

fn check_lattice(at: usize, track: &TrackRow) -> Result<(), FormatError> {
    let section = SectionKind::Tracks;
    reserved(section, at, "reserved", &[track.reserved])?;
    finite(section, at, "origin", &track.origin)?;
    finite(section, at, "step", &[track.step])?;
    if track.step <= 0.0 {
        let (field, found) = ("step", track.step);
        return Err(row(section, at, RowFault::NotAboveZero { field, found }));
    }
    if track.key_first != NONE {
        return Ok(());
    }
    reserved(section, at, "box_first", &[track.box_first])?;
    reserved(section, at, "box_interval", &[track.box_interval])?;
    if track.origin.map(f32::to_bits) != [0; 3] || track.step != 1.0 {
        return Err(row(section, at, RowFault::LatticeWithoutKeys));
    }
    Ok(())
}

/// Checks the keys of track `at`.
fn check_keys(view: &ModelView<'_>, segment: &Segment<'_>, at: usize, keys: &mut Tiling) -> Result<(), FormatError> {
    let first = view.tracks[at].key_first;
    let range = keys.take(SectionKind::Tracks, at, "key_first", first, segment.row.key_count)?;
    let last = range.end - 1;
    let section = SectionKind::Keys;
    for at in range {
        let KeyRow {
            map,
            bounds,
            flags,
            reserved: unused,
        } = &view.keys[at];
        reserved(section, at, "reserved", &[*unused])?;
        finite(section, at, "map", map)?;
        solid_box(section, at, "bounds", bounds)?;
        if *flags > KeyRow::CUT {
            let (field, found, limit) = ("flags", *flags, KeyRow::CUT + 1);
            return Err(row(section, at, RowFault::UnknownNumber { field, found, limit }));
        }
        if at == last && *flags != 0 {
            return Err(row(section, at, RowFault::CutAfterLastKey));
        }
    }
    Ok(())
}
