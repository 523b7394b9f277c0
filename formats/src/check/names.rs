use crate::{FormatError, ModelView, SectionKind};

/// Metadata lists have one entry per row that they name.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    let meta = &view.meta;
    let lists = [
        (
            "part_names",
            SectionKind::Parts,
            view.parts.len(),
            meta.part_names.len(),
        ),
        (
            "bone_names",
            SectionKind::Bones,
            view.bones.len(),
            meta.bone_names.len(),
        ),
        (
            "clip_names",
            SectionKind::Clips,
            view.clips.len(),
            meta.clip_names.len(),
        ),
    ];
    match lists.into_iter().find(|(_, _, expected, found)| expected != found) {
        Some((list, section, expected, found)) => Err(FormatError::MetaListLength {
            list,
            section,
            expected,
            found,
        }),
        None => Ok(()),
    }
}
