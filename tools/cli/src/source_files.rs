//! The files of one scene, as they stand on the command line.

use crate::failure::Failure;
use restpose_bake::import::{ImportSettings, Imported, import_files};
use std::path::{Path, PathBuf};

/// Sees that every file or folder is there, before any work.
pub fn check(paths: &[PathBuf]) -> Result<(), Failure> {
    paths.iter().try_for_each(|path| {
        std::fs::metadata(path)
            .map(drop)
            .map_err(|error| Failure::io("read", path, &error))
    })
}

/// The files of a scene that stands on the command line as one word: a path, or two that the last plus sign joins. A file
/// that is there is one, whatever its name.
pub fn joined(word: &Path) -> Vec<PathBuf> {
    let parts = word.to_str().and_then(|text| text.rsplit_once('+'));
    match parts {
        Some((mesh, cache)) if !word.exists() && !mesh.is_empty() && !cache.is_empty() => {
            vec![mesh.into(), cache.into()]
        }
        _ => vec![word.to_owned()],
    }
}

/// Reads a scene.
pub fn import(paths: &[PathBuf], settings: &ImportSettings) -> Result<Imported, Failure> {
    import_files(paths, settings).map_err(|error| Failure::import(first(paths), error))
}

/// The file that stands for all of them. The command line has at least one.
pub fn first(paths: &[PathBuf]) -> &Path {
    paths.first().map_or(Path::new(""), PathBuf::as_path)
}

/// What messages call them.
pub fn label(paths: &[PathBuf]) -> String {
    match paths {
        [only] => only.display().to_string(),
        [one, other] => format!("{} with {}", one.display(), other.display()),
        _ => format!("{} and {} more", first(paths).display(), paths.len().saturating_sub(1)),
    }
}

/// Their paths as text.
pub fn listed(paths: &[PathBuf]) -> Vec<String> {
    paths.iter().map(|path| path.display().to_string()).collect()
}
