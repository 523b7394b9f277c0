//! The rules that rows keep, so that whoever reads a [`ModelView`] may index without fear.
//!
//! Each file checks one group of sections. The order in [`model`] matters: a check may index plainly by what an
//! earlier one has found in range, and by nothing else.

mod caches;
pub(crate) mod clip_bounds;
mod clips;
mod cluster_bones;
mod cluster_morphs;
mod cluster_tracks;
mod clusters;
mod envelopes;
mod kd_trees;
mod key_boxes;
mod key_vertices;
mod levers;
mod membership;
mod morphs;
mod names;
mod node_movers;
mod numbers;
mod parts;
mod pose_spaces;
mod reference_boxes;
mod segments;
mod skeleton;
mod tiling;
mod tracks;
mod vertices;
mod wide_trees;

use crate::{FormatError, ModelView, RowFault, SectionKind, TreeKind};

/// Checks every rule. One implementation serves reader and writer.
///
/// Complexity: linear in the rows, plus the influences and morph deltas of each vertex, and its row in a segment, once
/// per cluster that uses it.
///
/// # Errors
/// The first rule that is broken.
pub(crate) fn model(view: &ModelView<'_>) -> Result<(), FormatError> {
    names::check(view)?;
    skeleton::check(view)?;
    parts::check(view)?;
    vertices::check(view)?;
    morphs::check(view)?;
    caches::check(view)?;
    segments::check(view)?;
    tracks::check(view)?;
    key_vertices::check(view)?;
    clips::check(view)?;
    clip_bounds::check(view)?;
    clusters::check(view)?;
    cluster_tracks::check(view)?;
    match view.meta.tree {
        TreeKind::Kd => {
            kd_trees::check(view)?;
            reference_boxes::check(view)?;
        }
        TreeKind::Wide => {
            wide_trees::check(view)?;
            node_movers::check(view)?;
        }
    }
    key_boxes::check(view)?;
    pose_spaces::check(view)?;
    levers::check(view)?;
    envelopes::check(view)?;
    membership::check(view)
}

/// The error of a row.
fn row(section: SectionKind, row: usize, fault: RowFault) -> FormatError {
    FormatError::Row {
        section,
        row: row as u64,
        fault,
    }
}
