//! glTF 2.0, as it is found in the wild.
//!
//! The JSON is read with our own few structures instead of those of the `gltf-json` crate. That crate stops at the
//! first element that does not fit, keeps attributes in a hash map (so their order is lost), refuses channels without
//! a target node (which the specification tells readers to ignore), and refuses a file for a fault in a material or a
//! camera, which no bake looks at.
//!
//! Stages: container → document (shapes) → extensions → buffers → nodes, meshes, skins, clips, parts. The first three
//! end the import when they fail; the others each report all that they find.

mod accessor;
mod buffers;
mod clips;
mod container;
mod document;
mod extensions;
mod forest;
mod influences;
mod keys;
mod meshes;
mod nodes;
mod parts;
mod schema;
mod skins;
mod topology;
mod transform;
mod uri;

use super::{Animation, Fault, ImportError, Imported, fault_list::FaultList};
use std::{io, path::Path};

pub(super) use extensions::remedy;

/// Reads glTF 2.0 from memory.
///
/// `name` stands in errors and in [`Animation::source_name`]; `load_buffer` gets percent-decoded paths relative to the
/// file. Guarantee and errors: as [`import`](super::import).
pub fn import_gltf_bytes(
    name: &str,
    bytes: &[u8],
    load_buffer: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Imported, ImportError> {
    import_gltf(Path::new(name), bytes, load_buffer)
}

/// As [`import_gltf_bytes`], for a file at `path`.
pub(super) fn import_gltf(
    path: &Path,
    bytes: &[u8],
    load_buffer: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Imported, ImportError> {
    let path = || path.to_owned();
    let failed = |faults: FaultList| ImportError::Faults {
        path: path(),
        faults: faults.into_faults(),
    };
    let foreign = |found: String| ImportError::UnknownFormat { path: path(), found };

    let mut faults = FaultList::default();
    let container = match container::split(bytes, &mut faults) {
        Ok(container) => container,
        Err(container::ContainerError::Foreign(found)) => return Err(foreign(found)),
        Err(container::ContainerError::Broken(fault)) => {
            faults.push(fault);
            return Err(failed(faults));
        }
    };
    let document = match document::parse(container.json, &mut faults) {
        Ok(document) => document,
        Err(document::DocumentError::Foreign(found)) => return Err(foreign(found)),
        Err(document::DocumentError::Broken) => return Err(failed(faults)),
    };
    let unsupported = |name: &&String| !extensions::is_accepted(name);
    let extensions: Vec<String> = document
        .extensions_required
        .iter()
        .filter(unsupported)
        .cloned()
        .collect();
    if !extensions.is_empty() {
        return Err(ImportError::UnsupportedExtensions {
            path: path(),
            extensions,
        });
    }

    let mut hash = blake3::Hasher::new();
    hash.update(bytes);
    let buffers = buffers::Buffers::load(&document, container.bin, load_buffer, &mut hash, &mut faults);
    let source_bytes = bytes.len().saturating_add(buffers.external_bytes());
    let accessors = accessor::Accessors::new(&document, &buffers, source_bytes);
    let mut animation = Animation {
        source_name: path()
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default(),
        source_hash: *hash.finalize().as_bytes(),
        ..Animation::default()
    };
    animation.nodes = nodes::read(&document, &mut faults);
    animation.meshes = meshes::read(&document, &accessors, &skins::joint_counts(&document), &mut faults);
    animation.skins = skins::read(&document, &accessors, &mut faults);
    let target_counts: Vec<usize> = animation.meshes.iter().map(|mesh| mesh.morph_target_count).collect();
    nodes::set_weights(&document, &accessors, &target_counts, &mut animation.nodes, &mut faults);
    animation.clips = clips::read(&document, &accessors, &target_counts, &mut faults);
    animation.parts = parts::read(&document, &accessors, &animation.nodes, &animation.meshes, &mut faults);
    if faults.has_errors() {
        return Err(failed(faults));
    }
    let faults: Vec<Fault> = faults.into_faults();
    Ok(Imported { animation, faults })
}
