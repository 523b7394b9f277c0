//! Readers of source files. Each gives an [`Animation`] or every fault it found.
//!
//! What of glTF 2.0 is read, how, and which test stands behind it: `tools/IMPORT.md`.

mod animation;
mod fault;
mod fault_list;
mod gltf;
mod magnitude;

use std::{
    io,
    path::{Path, PathBuf},
};

pub use animation::{Animation, Channel, ChannelTarget, Clip, Influence, Local, Mesh, Node, Part, Primitive, Skin, VertexCache};
pub use fault::{Fault, ImportError, Severity};
pub use gltf::import_gltf_bytes;
pub use magnitude::MAX_MAGNITUDE;

/// What an import gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// The scene, complete.
    pub animation: Animation,
    /// Warnings, in the order in which they were found; no errors.
    pub faults: Vec<Fault>,
}

/// Reads a glTF 2.0 file (`.gltf` or `.glb`, told apart by content) and the buffers beside it.
///
/// Guarantee: that of [`Animation`]; nothing outside `path` and the buffers that it names is opened. Never panics,
/// and takes time and memory in proportion to the size of the files.
///
/// # Errors
/// [`ImportError`]; every fault of one stage (JSON, then contents) is listed, not only the first.
pub fn import(path: &Path) -> Result<Imported, ImportError> {
    let bytes = std::fs::read(path).map_err(|source| ImportError::Read {
        path: path.to_owned(),
        source,
    })?;
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    gltf::import_gltf(path, &bytes, &|uri| read_buffer(&folder.join(PathBuf::from(uri))))
}

/// Reads a buffer, which must be an ordinary file: a named pipe or a device could block or never end.
fn read_buffer(path: &Path) -> io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file"));
    }
    std::fs::read(path)
}
