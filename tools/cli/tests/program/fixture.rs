use crate::run::restpose;
use restpose_formats::{AlignedBytes, read, write};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder of its own for a test.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// One of the bundled samples.
pub fn sample(name: &str) -> PathBuf {
    samples().join(name)
}

/// The folder of the bundled samples.
pub fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes")
}

/// Corners of a square of side two on the floor, as two triangles.
const FLOOR: [[f32; 3]; 6] = square([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]]);
/// Corners of an upright square that hangs on the y axis, as two triangles.
const DOOR: [[f32; 3]; 6] = square([[0.0, 0.1, 0.0], [0.8, 0.1, 0.0], [0.8, 1.1, 0.0], [0.0, 1.1, 0.0]]);
/// A quarter turn about y in one second. The second rotation is longer than one, which is a warning.
const TIMES: [f32; 2] = [0.0, 1.0];
const ROTATIONS: [[f32; 4]; 2] = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.8, 0.0, 0.8]];

const fn square([a, b, c, d]: [[f32; 3]; 4]) -> [[f32; 3]; 6] {
    [a, b, c, a, c, d]
}

/// Writes `door.gltf` and `door.bin`: a static floor, and a door that a clip swings.
pub fn door(folder: &Path) -> PathBuf {
    write_door(folder, &door_json(), FLOOR)
}

/// A door on a floor without area, and no door.
pub fn flat_door(folder: &Path) -> PathBuf {
    let mut json = door_json();
    json["nodes"][1].as_object_mut().expect("a node").remove("mesh");
    write_door(folder, &json, [[0.5; 3]; 6])
}

/// A door with these changes to its JSON.
pub fn changed_door(folder: &Path, change: impl FnOnce(&mut Value)) -> PathBuf {
    let mut json = door_json();
    change(&mut json);
    write_door(folder, &json, FLOOR)
}

fn write_door(folder: &Path, json: &Value, floor: [[f32; 3]; 6]) -> PathBuf {
    let numbers = floor
        .iter()
        .chain(&DOOR)
        .flatten()
        .chain(&TIMES)
        .chain(ROTATIONS.iter().flatten());
    let bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
    std::fs::write(folder.join("door.bin"), bytes).expect("room");
    let path = folder.join("door.gltf");
    std::fs::write(&path, json.to_string()).expect("room");
    path
}

fn door_json() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "name": "floor", "mesh": 0 }, { "name": "door", "mesh": 1 }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0 } }] },
            { "primitives": [{ "attributes": { "POSITION": 1 } }] },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1] },
            { "bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC3", "min": [0, 0.1, 0], "max": [0.8, 1.1, 0] },
            { "bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
            { "bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC4" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 72 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 72 },
            { "buffer": 0, "byteOffset": 144, "byteLength": 8 },
            { "buffer": 0, "byteOffset": 152, "byteLength": 32 },
        ],
        "buffers": [{ "uri": "door.bin", "byteLength": 184 }],
        "animations": [{
            "name": "swing",
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } }],
            "samplers": [{ "input": 2, "output": 3 }],
        }],
    })
}

/// Bakes the door to `door.rpose`.
pub fn baked_door(folder: &Path) -> PathBuf {
    door(folder);
    restpose(folder, ["bake", "door.gltf", "-o", "door.rpose"]).succeeded();
    folder.join("door.rpose")
}

/// A sound file whose geometry sticks out of its boxes, as `bad.rpose`: what `verify` is to find.
pub fn outgrown_door(folder: &Path) -> PathBuf {
    let bytes = AlignedBytes::copy_of(&std::fs::read(baked_door(folder)).expect("just baked"));
    let mut model = read(bytes.as_slice()).expect("a sound file").to_model();
    model
        .vertices
        .iter_mut()
        .for_each(|vertex| vertex.position_rest[0] *= 1.5);
    for row in &mut model.cluster_bones {
        row.bounds.min[0] *= 1.5;
        row.bounds.max[0] *= 1.5;
    }
    let path = folder.join("bad.rpose");
    std::fs::write(&path, write(&model).expect("still a sound file")).expect("room");
    path
}
