//! Readers of source files. Each gives an [`Animation`] or every fault it found.
//!
//! What is read, how, and which test stands behind it: `tools/IMPORT.md`.

mod animation;
mod cache;
mod connectivity;
mod fault;
mod fault_list;
mod gltf;
mod inputs;
mod keyframes;
mod magnitude;
mod mesh_files;
mod natural_order;
mod obj;
mod ordinary_file;
mod sequence;
mod settings;
mod timeline;

use fault_list::FaultList;
use inputs::Source;
use mesh_files::ReadFile;
use std::path::{Path, PathBuf};

pub use animation::{
    Animation, Channel, ChannelTarget, Clip, Influence, Local, Mesh, Node, Part, Primitive, Skin, VertexCache,
};
pub use connectivity::ConnectivityDifference;
pub use fault::{Fault, ImportError, Severity};
pub use gltf::import_gltf_bytes;
pub use magnitude::MAX_MAGNITUDE;
pub use mesh_files::import_obj_bytes;
pub use settings::{FrameRange, ImportSettings};

/// What an import gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// The scene, complete.
    pub animation: Animation,
    /// Warnings, in the order in which they were found; no errors.
    pub faults: Vec<Fault>,
}

/// Reads one source with default settings: a glTF file, an OBJ mesh, or a folder of OBJ files.
///
/// Guarantee and errors: as [`import_files`].
pub fn import(path: &Path) -> Result<Imported, ImportError> {
    import_files(&[path.to_owned()], &ImportSettings::default())
}

/// Reads the files of one scene: a glTF 2.0 file and the buffers beside it; an OBJ mesh; an OBJ mesh and its vertex
/// cache (PC2 or MDD), in any order; OBJ files as frames in the order given; or a folder of OBJ files as frames in
/// natural order of their names. Kinds are told by content where content tells, else by extension.
///
/// Guarantee: that of [`Animation`]; only ordinary files are opened, and only those named, the buffers that a glTF file
/// names, and the kept `.obj` files of a folder. Never panics, and takes time and memory in proportion to the size of
/// the files; of vertex caches and sequences, memory of the decoded positions and one file.
///
/// # Errors
/// [`ImportError`]; every fault of one stage is listed, not only the first: of a glTF file JSON, then contents; of a mesh
/// and its cache the mesh, then the cache; of a sequence each file.
pub fn import_files(inputs: &[PathBuf], settings: &ImportSettings) -> Result<Imported, ImportError> {
    settings.check()?;
    match inputs::tell(inputs)? {
        Source::Gltf(path) => import_gltf_file(&path, settings),
        Source::Mesh { mesh, cache } => {
            let read = |path: &PathBuf| ordinary_file::named(path, ordinary_file::read(path));
            let mesh_bytes = read(&mesh)?;
            let cache_bytes = cache.as_ref().map(read).transpose()?;
            let mesh_file = ReadFile {
                path: &mesh,
                bytes: &mesh_bytes,
            };
            let cache_file = cache.as_ref().zip(cache_bytes.as_ref());
            let cache_file = cache_file.map(|(path, bytes)| ReadFile { path, bytes });
            mesh_files::import_mesh(mesh_file, cache_file, settings)
        }
        Source::Sequence { named_after, files } => sequence::import_sequence(&named_after, &files, settings),
    }
}

fn import_gltf_file(path: &Path, settings: &ImportSettings) -> Result<Imported, ImportError> {
    let bytes = ordinary_file::named(path, ordinary_file::read(path))?;
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    let mut imported = gltf::import_gltf(path, &bytes, &|uri| ordinary_file::read(&folder.join(uri)))?;
    let mut unused = FaultList::default();
    mesh_files::warn_about_unused(settings, &mut unused);
    imported.faults.extend(unused.into_faults());
    Ok(imported)
}
