use restpose_runtime::{Asset, OpenError};
use std::path::Path;

/// Maps a `.rpose` file that this process has written, so that nothing of it is copied.
///
/// Files given by the user are read with [`Asset::open`] instead: nobody can promise that they stay as they are.
#[expect(
    unsafe_code,
    reason = "mapping a file is unsafe: another process could change it meanwhile"
)]
pub fn map_own_file(path: &Path) -> Result<Asset, OpenError> {
    // SAFETY: `Asset::map` asks that the file does not change while it is mapped. The caller has just written the
    // file whole into a temporary folder that only this process uses, does not touch it again, and renames it only
    // after the asset is gone.
    unsafe { Asset::map(path) }
}
