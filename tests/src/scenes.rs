use restpose_bake::{
    BakeSettings, NoProgress, bake,
    import::{Animation, import},
};
use restpose_runtime::Asset;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

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

/// Imports and bakes a scene with the default settings, through the bytes of its file.
///
/// # Panics
/// When any of that fails.
#[must_use]
pub fn baked_asset(path: &Path) -> (Animation, Arc<Asset>) {
    let animation = import(path).unwrap_or_else(|error| panic!("{error}")).animation;
    let asset = baked_with(&animation, &BakeSettings::default());
    (animation, asset)
}

/// Bakes an animation, through the bytes of its file.
///
/// # Panics
/// When that fails.
#[must_use]
pub fn baked_with(animation: &Animation, settings: &BakeSettings) -> Arc<Asset> {
    let baked = bake(animation, settings, &NoProgress).unwrap_or_else(|error| panic!("{error}"));
    let bytes = restpose_formats::write(&baked.model).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")))
}

/// Bakes an animation with samples every quarter of a second and at its keys, through the bytes of its file.
///
/// # Panics
/// When any of that fails.
#[must_use]
pub fn baked_animation(animation: &Animation) -> Arc<Asset> {
    let settings = BakeSettings {
        sample_step_seconds: 0.25,
        ..BakeSettings::default()
    };
    baked_with(animation, &settings)
}
