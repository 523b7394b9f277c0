//! Lays a classed animation out as the rows of a file: everything but clusters and trees.

mod clips;
mod degenerate;
mod geometry;
mod skeleton;
mod weights;

use crate::{BakeError, import::Animation, motion::Classified};
use restpose_formats::Model;

/// A model without clusters and trees.
pub(crate) struct Assembled {
    pub model: Model,
    /// Per part: the bones that may carry its triangles.
    pub bones_of_part: Vec<Vec<u32>>,
}

/// Builds the rows. `clips` are the selected clips, by their number in the source.
pub(crate) fn assemble(animation: &Animation, classes: &[Classified], clips: &[usize]) -> Result<Assembled, BakeError> {
    let mut model = Model::default();
    let skeleton = skeleton::add_skeleton(&mut model, animation, classes)?;
    let geometry = geometry::add_geometry(&mut model, animation, classes, &skeleton)?;
    clips::add_clips(&mut model, animation, clips, &skeleton, &geometry)?;
    Ok(Assembled {
        model,
        bones_of_part: skeleton.bones_of_part,
    })
}

/// A count as the file stores it.
pub(crate) fn row_count(what: &'static str, count: usize) -> Result<u32, BakeError> {
    // u32::MAX itself marks absent indices.
    u32::try_from(count)
        .ok()
        .filter(|count| *count < u32::MAX)
        .ok_or(BakeError::TooMany {
            what,
            found: count as u64,
        })
}
