use crate::{exit_code::ExitCode, failure::Failure};
use restpose_runtime::Asset;
use std::{path::Path, sync::Arc};

/// Sees that a file is there and is a file, before any work; gives its length in bytes.
pub fn check(path: &Path) -> Result<u64, Failure> {
    let metadata = std::fs::metadata(path).map_err(|error| Failure::io("read", path, &error))?;
    if metadata.is_dir() {
        let message = format!("{}: is a folder; name a file", path.display());
        return Err(Failure::at(ExitCode::CommandLine, path, message));
    }
    Ok(metadata.len())
}

/// Reads and checks a `.rpose` file.
pub fn open_asset(path: &Path) -> Result<Arc<Asset>, Failure> {
    check(path)?;
    Asset::open(path)
        .map(Arc::new)
        .map_err(|error| Failure::open(path, &error))
}
