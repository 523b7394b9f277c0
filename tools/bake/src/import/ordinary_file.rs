use super::ImportError;
use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

/// Length in bytes of a file, which must be an ordinary one: a named pipe or a device could block or never end.
pub(super) fn length(path: &Path) -> io::Result<u64> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file"));
    }
    Ok(metadata.len())
}

/// The contents of an ordinary file.
pub(super) fn read(path: &Path) -> io::Result<Vec<u8>> {
    length(path)?;
    std::fs::read(path)
}

/// The first bytes of an ordinary file, at most `count`.
pub(super) fn read_start(path: &Path, count: u64) -> io::Result<Vec<u8>> {
    length(path)?;
    let mut out = Vec::new();
    File::open(path)?.take(count).read_to_end(&mut out)?;
    Ok(out)
}

/// As [`ImportError::Read`].
pub(super) fn named<T>(path: &Path, result: io::Result<T>) -> Result<T, ImportError> {
    result.map_err(|source| ImportError::Read {
        path: path.to_owned(),
        source,
    })
}
