use super::{
    numbers::{extent, finite},
    row,
};
use crate::{FormatError, ModelView, RowFault, SectionKind};

/// Relative motions are finite and their reaches not negative; intervals of morph weights are finite and hold a weight.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let section = SectionKind::BoneEnvelopes;
    for (at, envelope) in view.bone_envelopes.iter().enumerate() {
        finite(section, at, "center", &envelope.center)?;
        finite(section, at, "direction", &envelope.direction)?;
        extent(section, at, "reach", &envelope.reach)?;
    }
    let section = SectionKind::MorphEnvelopes;
    for (at, weights) in view.morph_envelopes.iter().enumerate() {
        let (min, max) = (weights.min, weights.max);
        finite(section, at, "min", &[min])?;
        finite(section, at, "max", &[max])?;
        if min > max {
            return Err(row(section, at, RowFault::EmptyInterval { min, max }));
        }
    }
    Ok(())
}
