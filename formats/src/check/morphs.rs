use super::{
    numbers::{extent, finite, index_within, reserved, within_extent},
    row,
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{MorphDeltaRow, MorphTargetRow, NONE},
};
use std::ops::Range;

/// Morph sets tile the targets; a vertex's deltas name targets of its part's set in ascending order and stay within
/// their extents. Parts and vertices have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let mut targets = Tiling::new(SectionKind::MorphTargets, view.morph_targets.len());
    for (at, set) in view.morph_sets.iter().enumerate() {
        let section = SectionKind::MorphSets;
        reserved(section, at, "reserved", &[set.reserved])?;
        targets.take(section, at, "target_first", set.target_first, set.target_count)?;
    }
    targets.finish()?;
    for (at, target) in view.morph_targets.iter().enumerate() {
        let section = SectionKind::MorphTargets;
        finite(section, at, "default_weight", &[target.default_weight])?;
        extent(section, at, "extent", &target.extent)?;
    }
    if view.morph_deltas.is_empty() && view.morph_first.is_empty() {
        return Ok(());
    }
    check_firsts(view)?;
    check_deltas(view)
}

/// One entry per vertex row, none of them falling, from zero to the number of deltas.
fn check_firsts(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::MorphFirst;
    let field = "first";
    let expected = if view.morph_deltas.is_empty() {
        0
    } else {
        view.vertices.len() as u64
    };
    let found = view.morph_first.len() as u64;
    if found != expected {
        return Err(FormatError::RowCount {
            section,
            expected,
            found,
        });
    }
    let mut previous = None;
    for (at, found) in view.morph_first.iter().copied().enumerate() {
        match previous {
            None if found != 0 => {
                let fault = RowFault::RangeNotContiguous {
                    field,
                    found: u64::from(found),
                    expected: 0,
                };
                return Err(row(section, at, fault));
            }
            Some(previous) if found < previous => {
                return Err(row(section, at, RowFault::Descending { field, found, previous }));
            }
            _ => previous = Some(found),
        }
    }
    let expected = previous.map_or(0, u64::from);
    let found = view.morph_deltas.len() as u64;
    if expected == found {
        Ok(())
    } else {
        Err(FormatError::RowCount {
            section: SectionKind::MorphDeltas,
            expected,
            found,
        })
    }
}

fn check_deltas(view: &ModelView<'_>) -> Result<(), FormatError> {
    for part in view.parts {
        let targets = if part.morph_set == NONE {
            None
        } else {
            let set = view.morph_sets[part.morph_set as usize];
            let first = set.target_first as usize;
            Some(first..first + set.target_count as usize)
        };
        let first = part.vertex_first as usize;
        for vertex in first..first + part.vertex_count as usize {
            let range = view.morph_first[vertex] as usize..view.morph_first[vertex + 1] as usize;
            match &targets {
                None if range.is_empty() => {}
                None => {
                    let fault = RowFault::DeltaWithoutMorphSet { vertex: vertex as u64 };
                    return Err(row(SectionKind::MorphDeltas, range.start, fault));
                }
                Some(targets) => check_vertex(view, range, targets)?,
            }
        }
    }
    Ok(())
}

fn check_vertex(view: &ModelView<'_>, deltas: Range<usize>, targets: &Range<usize>) -> Result<(), FormatError> {
    let section = SectionKind::MorphDeltas;
    let mut previous = None;
    for at in deltas {
        let MorphDeltaRow { target, delta } = view.morph_deltas[at];
        index_within(section, at, "target", target, targets)?;
        if let Some(previous) = previous
            && target <= previous
        {
            let fault = RowFault::NotAscending {
                field: "target",
                found: target,
                previous,
            };
            return Err(row(section, at, fault));
        }
        previous = Some(target);
        finite(section, at, "delta", &delta)?;
        let MorphTargetRow { extent, .. } = view.morph_targets[target as usize];
        within_extent(section, at, "delta", delta, extent, target as usize)?;
    }
    Ok(())
}
