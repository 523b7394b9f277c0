//! The bundled samples, and real characters where the folder with them stands beside the workspace.

use restpose_bake::import::{Animation, ImportSettings, import, import_files};
use std::path::{Path, PathBuf};

fn scene(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/scenes")
        .join(name);
    path.exists().then_some(path)
}

fn triangle_count(animation: &Animation) -> usize {
    let primitives = animation
        .parts
        .iter()
        .flat_map(|part| &animation.meshes[part.mesh].primitives);
    primitives.map(|primitive| primitive.triangles.len()).sum()
}

#[test]
fn fox_has_its_triangles_clips_and_joints() {
    let Some(path) = scene("fox/Fox.glb") else {
        return;
    };
    let imported = import(&path).unwrap();
    let animation = imported.animation;
    assert_eq!(triangle_count(&animation), 576);
    assert_eq!(
        animation
            .clips
            .iter()
            .map(|clip| clip.name.as_str())
            .collect::<Vec<_>>(),
        ["Survey", "Walk", "Run"]
    );
    assert_eq!(animation.skins[0].joints.len(), 24);
    assert_eq!((animation.parts.len(), animation.parts[0].skin), (1, Some(0)));
    assert_eq!(animation.source_name, "Fox.glb");
    assert_eq!(imported.faults, []);
}

#[test]
fn cesium_man_has_its_triangles_clip_and_joints() {
    let Some(path) = scene("cesium_man/cesium_man.gltf") else {
        return;
    };
    let imported = import(&path).unwrap();
    let animation = imported.animation;
    assert_eq!(triangle_count(&animation), 4672);
    assert_eq!(animation.clips.len(), 1);
    assert_eq!(animation.clips[0].channels.len(), 57);
    assert_eq!(animation.skins[0].joints.len(), 19);
    // A flaw of this file: the weights of 191 vertices sum to as little as 0.18.
    assert_eq!(imported.faults.len(), 1, "{:?}", imported.faults);
    assert!(
        imported.faults[0].message.contains("191 vertices"),
        "{:?}",
        imported.faults
    );
}

#[test]
fn the_bundled_samples_import_without_warning() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if !path
            .extension()
            .is_some_and(|extension| extension == "glb" || extension == "gltf")
        {
            continue;
        }
        count += 1;
        let imported = import(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(imported.faults, [], "{}", path.display());
    }
    assert!(count > 0);
}

#[test]
fn vertex_caches_have_their_triangles_and_frames_and_begin_as_their_mesh() {
    for (name, triangles, points, frames) in [
        ("chicken", 5_664, 3_030, 400),
        ("cow", 5_804, 2_904, 204),
        ("horse", 16_843, 8_431, 48),
        ("elephant", 84_638, 42_321, 48),
    ] {
        let Some(folder) = scene(name) else {
            return;
        };
        let inputs = ["obj", "pc2"].map(|extension| folder.join(name).with_extension(extension));
        let imported = import_files(&inputs, &ImportSettings::default()).unwrap();
        assert_eq!(imported.faults, [], "{name}");
        let animation = imported.animation;
        assert_eq!(triangle_count(&animation), triangles, "{name}");
        let cache = &animation.caches[0];
        assert_eq!((cache.point_count, cache.frame_count()), (points, frames), "{name}");
        assert_eq!(animation.clips[0].name, name);
        // The text and the binary file of the first frame agree to the bit.
        let mesh = import(&inputs[0]).unwrap().animation;
        assert_eq!(
            mesh.meshes[0].primitives[0].triangles, animation.meshes[0].primitives[0].triangles,
            "{name}"
        );
        assert_eq!(
            mesh.meshes[0].primitives[0].positions, animation.meshes[0].primitives[0].positions,
            "{name}"
        );
    }
}

#[test]
fn bunny_has_its_triangles() {
    let Some(path) = scene("bunny/bunny.obj") else {
        return;
    };
    let imported = import(&path).unwrap();
    assert_eq!(
        (triangle_count(&imported.animation), imported.faults),
        (69_451, Vec::new())
    );
}
