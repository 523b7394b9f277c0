//! The generated glTF files against the rules of the glTF 2.0 specification, by a walk over their JSON that shares
//! nothing with the writer.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use restpose_samples::{SceneFile, scene_files};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A file's JSON and its one buffer.
struct Loaded {
    name: &'static str,
    json: Value,
    buffer: Vec<u8>,
}

fn u32_at(bytes: &[u8], offset: usize) -> usize {
    u32::from_le_bytes(bytes[offset..offset + 4].try_into().expect("four bytes")) as usize
}

fn loaded() -> Vec<Loaded> {
    let files = scene_files().expect("the scenes are written");
    let scenes = files
        .iter()
        .filter(|file| file.name.ends_with(".gltf") || file.name.ends_with(".glb"));
    scenes.map(|file| load(file, &files)).collect()
}

fn load(file: &SceneFile, files: &[SceneFile]) -> Loaded {
    let name = file.name;
    if name.ends_with(".glb") {
        // 12 bytes of header; then per chunk its length, its type and its bytes.
        assert_eq!(&file.bytes[..4], b"glTF");
        assert_eq!(u32_at(&file.bytes, 4), 2);
        assert_eq!(u32_at(&file.bytes, 8), file.bytes.len());
        let json_length = u32_at(&file.bytes, 12);
        assert_eq!(&file.bytes[16..20], b"JSON");
        let binary = 20 + json_length;
        assert_eq!(binary % 4, 0);
        assert_eq!(&file.bytes[binary + 4..binary + 8], b"BIN\0");
        assert_eq!(binary + 8 + u32_at(&file.bytes, binary), file.bytes.len());
        return Loaded {
            name,
            json: serde_json::from_slice(&file.bytes[20..binary]).expect("JSON"),
            buffer: file.bytes[binary + 8..].to_vec(),
        };
    }
    let json: Value = serde_json::from_slice(&file.bytes).expect("JSON");
    let uri = json["buffers"][0]["uri"].as_str().expect("a URI");
    let buffer = match uri.split_once(";base64,") {
        Some((_, encoded)) => STANDARD.decode(encoded).expect("base64"),
        None => {
            let beside = files.iter().find(|file| file.name == uri);
            beside.expect("the buffer's file").bytes.clone()
        }
    };
    Loaded { name, json, buffer }
}

fn count(value: &Value, key: &str) -> usize {
    value[key].as_u64().unwrap_or(0) as usize
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn component_bytes(code: usize) -> usize {
    match code {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | 5126 => 4,
        _ => panic!("component type {code}"),
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        _ => panic!("type {kind}"),
    }
}

impl Loaded {
    /// Rows of numbers as stored, without normalisation; checks range and alignment on the way.
    fn rows(&self, view: usize, offset: usize, code: usize, width: usize, count_rows: usize) -> Vec<Vec<f64>> {
        let view = &self.json["bufferViews"][view];
        let size = component_bytes(code);
        let stride = match count(view, "byteStride") {
            0 => size * width,
            stride => stride,
        };
        let start = count(view, "byteOffset") + offset;
        assert_eq!(start % size, 0, "{}: alignment", self.name);
        assert_eq!(stride % size, 0, "{}: stride", self.name);
        let last = offset + stride * (count_rows - 1) + size * width;
        assert!(last <= count(view, "byteLength"), "{}: range", self.name);
        let number = |at: usize| {
            let bytes = &self.buffer[at..at + size];
            match code {
                5120 => f64::from(bytes[0] as i8),
                5121 => f64::from(bytes[0]),
                5122 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
                5123 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                5125 => f64::from(u32::from_le_bytes(bytes.try_into().expect("four bytes"))),
                _ => f64::from(f32::from_le_bytes(bytes.try_into().expect("four bytes"))),
            }
        };
        (0..count_rows)
            .map(|row| {
                let first = start + stride * row;
                (0..width).map(|column| number(first + column * size)).collect()
            })
            .collect()
    }

    fn accessor(&self, index: usize) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][index];
        let code = count(accessor, "componentType");
        let width = width(accessor["type"].as_str().expect("a type"));
        let length = count(accessor, "count");
        assert!(length > 0, "{}: accessor {index} is empty", self.name);
        let mut rows = match accessor["bufferView"].as_u64() {
            Some(view) => {
                let offset = count(accessor, "byteOffset");
                self.rows(view as usize, offset, code, width, length)
            }
            None => vec![vec![0.0; width]; length],
        };
        let sparse = &accessor["sparse"];
        if sparse.is_object() {
            let (indices, values) = (&sparse["indices"], &sparse["values"]);
            let replaced = count(sparse, "count");
            let code_of_indices = count(indices, "componentType");
            let view = count(indices, "bufferView");
            let numbers = self.rows(view, 0, code_of_indices, 1, replaced);
            assert!(numbers.is_sorted_by(|a, b| a[0] < b[0]));
            let values = self.rows(count(values, "bufferView"), 0, code, width, replaced);
            for (number, value) in numbers.iter().zip(values) {
                rows[number[0] as usize] = value;
            }
        }
        rows
    }

    fn primitives(&self) -> impl Iterator<Item = (String, &Value)> {
        list(&self.json, "meshes").iter().flat_map(move |mesh| {
            let name = mesh["name"].as_str().unwrap_or("");
            let primitives = list(mesh, "primitives").iter().enumerate();
            primitives.map(move |(number, primitive)| (format!("{} {name} {number}", self.name), primitive))
        })
    }

    fn triangles(&self, primitive: &Value) -> Vec<[usize; 3]> {
        let vertices = count(
            &self.json["accessors"][count(&primitive["attributes"], "POSITION")],
            "count",
        );
        let order: Vec<usize> = match primitive["indices"].as_u64() {
            Some(accessor) => {
                let rows = self.accessor(accessor as usize);
                rows.iter().map(|row| row[0] as usize).collect()
            }
            None => (0..vertices).collect(),
        };
        assert!(order.iter().all(|&vertex| vertex < vertices));
        let triple = |at: [usize; 3]| at.map(|place| order[place]);
        let windows = 0..order.len().saturating_sub(2);
        match primitive["mode"].as_u64().unwrap_or(4) {
            4 => {
                assert_eq!(order.len() % 3, 0);
                let triples = windows.step_by(3);
                triples.map(|i| triple([i, i + 1, i + 2])).collect()
            }
            5 => windows.map(|i| triple([i, i + 1 + i % 2, i + 2 - i % 2])).collect(),
            6 => windows.map(|i| triple([i + 1, i + 2, 0])).collect(),
            mode => panic!("mode {mode}"),
        }
    }
}

#[test]
fn accessors_lie_in_their_buffers_and_state_their_bounds() {
    for file in loaded() {
        assert_eq!(count(&file.json["buffers"][0], "byteLength"), file.buffer.len());
        for view in list(&file.json, "bufferViews") {
            let end = count(view, "byteOffset") + count(view, "byteLength");
            assert!(end <= file.buffer.len());
            assert_eq!(count(view, "byteOffset") % 4, 0);
        }
        for (index, accessor) in list(&file.json, "accessors").iter().enumerate() {
            let rows = file.accessor(index);
            for (key, pick) in [("min", f64::min as fn(f64, f64) -> f64), ("max", f64::max)] {
                for (column, stated) in list(accessor, key).iter().enumerate() {
                    let values = rows.iter().map(|row| row[column]);
                    let found = values.reduce(pick).expect("rows");
                    // The shortest text of an f32 stands for that f32.
                    let stated = match count(accessor, "componentType") {
                        5126 => f64::from(stated.as_f64().expect("a number") as f32),
                        _ => stated.as_f64().expect("a number"),
                    };
                    assert_eq!(stated, found, "{} accessor {index} {key}", file.name);
                }
            }
        }
    }
}

#[test]
fn vertex_data_follows_the_rules() {
    for file in loaded() {
        let target = |accessor: usize| {
            let view = count(&file.json["accessors"][accessor], "bufferView");
            (view, count(&file.json["bufferViews"][view], "target"))
        };
        for (name, primitive) in file.primitives() {
            let attributes = primitive["attributes"].as_object().expect("attributes");
            let mut counts = BTreeSet::new();
            for accessor in attributes.values() {
                let accessor = accessor.as_u64().expect("an accessor") as usize;
                let (view, target) = target(accessor);
                assert_eq!(target, 34962, "{name}");
                let stride = count(&file.json["bufferViews"][view], "byteStride");
                assert_eq!(stride % 4, 0, "{name}");
                counts.insert(count(&file.json["accessors"][accessor], "count"));
            }
            let position = &file.json["accessors"][count(&primitive["attributes"], "POSITION")];
            assert_eq!(list(position, "min").len(), 3, "{name}");
            assert_eq!(list(position, "max").len(), 3, "{name}");
            for morph in list(primitive, "targets") {
                let accessor = &file.json["accessors"][count(morph, "POSITION")];
                assert_eq!(list(accessor, "min").len(), 3, "{name}");
                counts.insert(count(accessor, "count"));
            }
            assert_eq!(counts.len(), 1, "{name}: attributes differ in length");
            if let Some(accessor) = primitive["indices"].as_u64() {
                assert_eq!(target(accessor as usize).1, 34963, "{name}");
            }
        }
    }
}

#[test]
fn surfaces_are_closed_and_outward() {
    for file in loaded() {
        // Several primitives of a mesh may make one solid, so corners are told apart by position.
        let mut meshes: BTreeMap<String, Vec<[[u64; 3]; 3]>> = BTreeMap::new();
        for (name, primitive) in file.primitives() {
            let positions = file.accessor(count(&primitive["attributes"], "POSITION"));
            let mesh = name.rsplit_once(' ').expect("a number").0.to_owned();
            let corner = |vertex: usize| -> [u64; 3] { core::array::from_fn(|axis| positions[vertex][axis].to_bits()) };
            let triangles = file.triangles(primitive).into_iter();
            let corners = triangles.map(|triangle| triangle.map(corner));
            meshes.entry(mesh).or_default().extend(corners);
        }
        for (mesh, triangles) in meshes {
            let mut balance: BTreeMap<[[u64; 3]; 2], i64> = BTreeMap::new();
            let mut sixfold_volume = 0.0;
            for corners in triangles {
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    let (from, to) = (corners[from], corners[to]);
                    *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
                }
                let [a, b, c] = corners.map(|corner| corner.map(f64::from_bits));
                sixfold_volume += a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]);
            }
            assert!(balance.values().all(|&sum| sum == 0), "{mesh} is open");
            assert!(sixfold_volume > 0.0, "{mesh} is inside out");
        }
    }
}

#[test]
fn skins_and_weights_follow_the_rules() {
    for file in loaded() {
        for skin in list(&file.json, "skins") {
            let matrices = file.accessor(count(skin, "inverseBindMatrices"));
            assert_eq!(matrices.len(), list(skin, "joints").len());
            for matrix in matrices {
                assert_eq!([matrix[3], matrix[7], matrix[11], matrix[15]], [0.0, 0.0, 0.0, 1.0]);
            }
        }
        for node in list(&file.json, "nodes") {
            let Some(skin) = node["skin"].as_u64() else {
                continue;
            };
            let joints = list(&file.json["skins"][skin as usize], "joints").len();
            let mesh = &file.json["meshes"][count(node, "mesh")];
            for primitive in list(mesh, "primitives") {
                check_influences(&file, &primitive["attributes"], joints);
            }
        }
    }
}

fn check_influences(file: &Loaded, attributes: &Value, joint_count: usize) {
    let sets = (0..).take_while(|set| attributes[format!("JOINTS_{set}")].is_u64());
    let mut influences: Vec<Vec<(usize, f64)>> = Vec::new();
    let mut whole = 1.0;
    for set in sets {
        let joints = file.accessor(count(attributes, &format!("JOINTS_{set}")));
        let accessor = count(attributes, &format!("WEIGHTS_{set}"));
        whole = match count(&file.json["accessors"][accessor], "componentType") {
            5121 => 255.0,
            5123 => 65_535.0,
            _ => 1.0,
        };
        let weights = file.accessor(accessor);
        influences.resize(joints.len(), Vec::new());
        for ((row, joints), weights) in influences.iter_mut().zip(joints).zip(weights) {
            row.extend(joints.iter().map(|&joint| joint as usize).zip(weights));
        }
    }
    assert!(!influences.is_empty(), "{}: no influences", file.name);
    for row in influences {
        let sum: f64 = row.iter().map(|&(_, weight)| weight).sum();
        if whole == 1.0 {
            // Eight roundings to f32, each of at most 2^-25.
            assert!((sum - 1.0).abs() <= 8.0 / 33_554_432.0, "{sum}");
        } else {
            assert_eq!(sum, whole);
        }
        assert!(row.iter().all(|&(joint, weight)| weight > 0.0 || joint == 0));
        assert!(row.iter().all(|&(joint, _)| joint < joint_count));
        let heavy = row.iter().filter(|&&(_, weight)| weight > 0.0);
        let distinct: BTreeSet<_> = heavy.clone().map(|&(joint, _)| joint).collect();
        assert_eq!(distinct.len(), heavy.count(), "a joint twice on one vertex");
    }
}

#[test]
fn nodes_are_named_and_form_a_forest() {
    for file in loaded() {
        let nodes = list(&file.json, "nodes");
        let mut parents = vec![0; nodes.len()];
        let roots = list(&file.json["scenes"][0], "nodes");
        let children = nodes.iter().flat_map(|node| list(node, "children"));
        for node in roots.iter().chain(children) {
            parents[node.as_u64().expect("a node") as usize] += 1;
        }
        // Children are made after their parents, so one parent each rules out a cycle.
        assert!(parents.iter().all(|&parents| parents == 1), "{}", file.name);
        let mut names = BTreeSet::new();
        for (index, node) in nodes.iter().enumerate() {
            let name = node["name"].as_str().unwrap_or("");
            assert!(!name.is_empty() && names.insert(name), "{}: {name}", file.name);
            for child in list(node, "children") {
                assert!(child.as_u64().expect("a node") as usize > index);
            }
            let matrix = node["matrix"].is_array();
            let parts = ["translation", "rotation", "scale"];
            assert!(!matrix || parts.iter().all(|part| node[part].is_null()));
        }
        for kind in ["meshes", "skins", "animations", "materials"] {
            for object in list(&file.json, kind) {
                assert!(!object["name"].as_str().unwrap_or("").is_empty());
            }
        }
    }
}

#[test]
fn clips_follow_the_rules() {
    for file in loaded() {
        for clip in list(&file.json, "animations") {
            let mut targets = BTreeSet::new();
            for channel in list(clip, "channels") {
                let target = &channel["target"];
                let path = target["path"].as_str().expect("a path");
                let node = count(target, "node");
                assert!(targets.insert((node, path)), "{}: moved twice", file.name);
                assert!(file.json["nodes"][node]["matrix"].is_null());
                let sampler = &clip["samplers"][count(channel, "sampler")];
                check_sampler(&file, sampler, node, path);
            }
        }
    }
}

fn check_sampler(file: &Loaded, sampler: &Value, node: usize, path: &str) {
    let input = count(sampler, "input");
    let times = file.accessor(input);
    assert!(times.is_sorted_by(|a, b| a[0] < b[0]), "times must ascend");
    assert!(times[0][0] >= 0.0);
    assert_eq!(list(&file.json["accessors"][input], "max").len(), 1);
    let spline = sampler["interpolation"] == "CUBICSPLINE";
    let mesh = &file.json["meshes"][count(&file.json["nodes"][node], "mesh")];
    let per_value = match path {
        "weights" => list(&mesh["primitives"][0], "targets").len(),
        _ => 1,
    };
    let values = file.accessor(count(sampler, "output"));
    let per_key = if spline { 3 } else { 1 };
    assert_eq!(values.len(), times.len() * per_key * per_value);
    if path == "rotation" {
        let keys = values.iter().skip(per_key / 2).step_by(per_key);
        for key in keys.clone() {
            let length: f64 = key.iter().map(|value| value * value).sum();
            // Four roundings to f32 of numbers up to one.
            assert!((length - 1.0).abs() < 4.0 / 8_388_608.0, "{length}");
        }
        // Slerp takes the shorter way, so a key must not lie half a turn or more from the last one.
        let followers = keys.clone().skip(1);
        for (from, to) in keys.zip(followers) {
            let dot: f64 = from.iter().zip(to).map(|(a, b)| a * b).sum();
            assert!(sampler["interpolation"] == "STEP" || dot.abs() > 0.5);
        }
    }
}

#[test]
fn the_scenes_cover_what_they_promise() {
    let scenes = loaded();
    let scene = |name: &str| scenes.iter().find(|scene| scene.name == name).expect("a scene");
    let clips = |name: &str| -> Vec<String> {
        let clips = list(&scene(name).json, "animations").iter();
        clips
            .map(|clip| clip["name"].as_str().unwrap_or("").to_owned())
            .collect()
    };
    assert_eq!(clips("walker.glb"), ["walk", "wave"]);
    assert_eq!(clips("tentacle.gltf"), ["curl", "sway"]);
    assert_eq!(clips("machine.gltf"), ["run", "signal"]);
    assert_eq!(clips("mixed.glb"), ["bustle", "breeze"]);

    let modes = |name: &str| -> BTreeSet<u64> {
        let primitives = scene(name).primitives();
        primitives
            .map(|(_, primitive)| primitive["mode"].as_u64().unwrap_or(4))
            .collect()
    };
    assert_eq!(modes("machine.gltf"), BTreeSet::from([4, 5, 6]));
    let walker = scene("walker.glb");
    let triangles: usize = walker
        .primitives()
        .map(|(_, primitive)| walker.triangles(primitive).len())
        .sum();
    assert!((2_000..5_000).contains(&triangles), "{triangles}");
    let text = |name: &str| scene(name).json.to_string();
    for (name, wanted) in [
        ("walker.glb", "CUBICSPLINE"),
        ("tentacle.gltf", "WEIGHTS_1"),
        ("machine.gltf", "STEP"),
        ("machine.gltf", "-1.0,1.0,1.0"),
        ("mixed.glb", "sparse"),
        ("mixed.glb", "matrix"),
        ("mixed.glb", "KHR_mesh_quantization"),
        ("mixed.glb", "targets"),
    ] {
        assert!(text(name).contains(wanted), "{name} lacks {wanted}");
    }
}
