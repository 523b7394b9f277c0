use std::path::{Path, PathBuf};

/// The bundled sample scenes, sorted.
#[must_use]
pub fn sample_scenes() -> Vec<PathBuf> {
    gltf_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes"))
}

/// The bundled samples, then the glTF files of the optional scene folder beside the repository.
#[must_use]
pub fn source_scenes() -> Vec<PathBuf> {
    let mut scenes = sample_scenes();
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let mut folders: Vec<PathBuf> = shared
        .read_dir()
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    folders.sort();
    scenes.extend(folders.iter().flat_map(|folder| gltf_files(folder)));
    scenes
}

fn gltf_files(folder: &Path) -> Vec<PathBuf> {
    let is_gltf = |path: &PathBuf| {
        path.extension()
            .is_some_and(|extension| extension == "gltf" || extension == "glb")
    };
    let entries = folder.read_dir().into_iter().flatten();
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(is_gltf)
        .collect();
    files.sort();
    files
}
