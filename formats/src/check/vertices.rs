use super::{
    numbers::{finite, index, reserved},
    row,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{InfluenceRow, NONE, WEIGHT_STEP},
};
use std::ops::Range;

/// Steps of [`WEIGHT_STEP`] in a weight of one.
const ONE: u64 = 1 << 24;

/// Positions are finite, influences tile the vertices, and each vertex's weights sum to exactly one over distinct
/// bones. There is a closing row: the parts have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    check_firsts(view)?;
    // Row of the last vertex that each bone moves.
    let mut moved_last = vec![NONE; view.bones.len()];
    for (at, pair) in view.vertices.windows(2).enumerate() {
        let [vertex, next] = pair else { continue };
        finite(SectionKind::Vertices, at, "position_rest", &vertex.position_rest)?;
        let range = vertex.influence_first as usize..next.influence_first as usize;
        check_influences(&view.influences[range.clone()], range, at, &mut moved_last)?;
    }
    Ok(())
}

fn check_firsts(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::Vertices;
    let field = "influence_first";
    let mut previous = None;
    for (at, vertex) in view.vertices.iter().enumerate() {
        let found = vertex.influence_first;
        match previous {
            None if found != 0 => {
                let fault = RowFault::RangeNotContiguous {
                    field,
                    found: u64::from(found),
                    expected: 0,
                };
                return Err(row(section, at, fault));
            }
            Some(previous) if found <= previous => {
                return Err(row(section, at, RowFault::NotAscending { field, found, previous }));
            }
            _ => previous = Some(found),
        }
    }
    let expected = previous.map_or(0, u64::from);
    let found = view.influences.len() as u64;
    if expected != found {
        return Err(FormatError::RowCount {
            section: SectionKind::Influences,
            expected,
            found,
        });
    }
    let Some(closing) = view.vertices.last() else {
        return Ok(());
    };
    let words = closing.position_rest.map(f32::to_bits);
    reserved(section, view.vertices.len() - 1, "position_rest", &words)
}

fn check_influences(
    influences: &[InfluenceRow],
    range: Range<usize>,
    vertex: usize,
    moved_last: &mut [u32],
) -> Result<(), FormatError> {
    let section = SectionKind::Influences;
    let mut sum = 0;
    for (at, influence) in range.zip(influences) {
        let bone = index(section, at, "bone", influence.bone, moved_last.len())?;
        if moved_last[bone] == vertex as u32 {
            let fault = RowFault::RepeatedInfluence { bone: influence.bone };
            return Err(row(SectionKind::Vertices, vertex, fault));
        }
        moved_last[bone] = vertex as u32;
        let Some(steps) = weight_steps(influence.weight) else {
            return Err(row(
                section,
                at,
                RowFault::Weight {
                    found: influence.weight,
                },
            ));
        };
        sum += steps;
    }
    if sum == ONE {
        Ok(())
    } else {
        Err(row(
            SectionKind::Vertices,
            vertex,
            RowFault::WeightSum { found_steps: sum },
        ))
    }
}

/// The weight in units of [`WEIGHT_STEP`], where it is a whole positive number of them and at most one.
fn weight_steps(weight: f32) -> Option<u64> {
    // Dividing by a power of two is exact, and so is the conversion back of an integer up to 2^24.
    let steps = weight / WEIGHT_STEP;
    let whole = steps as u32;
    let valid = weight > 0.0 && weight <= 1.0 && whole as f32 == steps;
    valid.then_some(u64::from(whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_counted_in_whole_steps() {
        assert_eq!(weight_steps(1.0), Some(ONE));
        assert_eq!(weight_steps(WEIGHT_STEP), Some(1));
        assert_eq!(weight_steps(1.0 - WEIGHT_STEP), Some(ONE - 1));
        for wrong in [
            0.0,
            -0.5,
            1.0f32.next_up(),
            0.5 * WEIGHT_STEP,
            1.5 * WEIGHT_STEP,
            f32::NAN,
        ] {
            assert_eq!(weight_steps(wrong), None, "{wrong}");
        }
    }
}
