//! Whatever is changed in a file, an import ends with errors or keeps the guarantee of [`Animation`].

use crate::gltf_builder::{BYTE, Gltf, UNSIGNED_BYTE};
use restpose_bake::import::{Animation, Channel, ChannelTarget, ImportError, Local, MAX_MAGNITUDE, Severity};
use serde_json::{Value, json};

/// A file that uses most of what is read: skin, sparse and quantised morph targets, strip, matrix node, three clips.
fn rich() -> Gltf {
    let mut gltf = Gltf::skinned();
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 4, &[0, 1, 2, 1]);
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["mode"] = json!(5);
    let target = gltf.normalized(BYTE, "VEC3", 3, &[1; 9]);
    let (places, values) = (gltf.view(&[2]), gltf.view(&[0x81; 3]));
    gltf.json["accessors"][target]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": places, "byteOffset": 0, "componentType": UNSIGNED_BYTE },
        "values": { "bufferView": values, "byteOffset": 0 },
    });
    gltf.primitive()["targets"] = json!([{ "POSITION": target }]);
    gltf.json["meshes"][0]["weights"] = json!([0.5]);
    gltf.json["nodes"][0]["weights"] = json!([0.25]);
    gltf.json["nodes"][2]["rotation"] = json!([0, 0, 0, 1]);
    gltf.json["nodes"][2]["scale"] = json!([1, 2, 3]);
    gltf.push(
        "nodes",
        json!({ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "name": "n" }),
    );
    let matrix = [
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let matrices = gltf.f32s("MAT4", &matrix.repeat(2));
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    gltf.json["skins"][0]["skeleton"] = json!(1);
    let times = gltf.f32s("SCALAR", &[0.0, 1.0]);
    let outputs = [
        (
            1,
            "rotation",
            "LINEAR",
            gltf.f32s("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]),
        ),
        (2, "translation", "CUBICSPLINE", gltf.f32s("VEC3", &[1.0; 18])),
        (0, "weights", "STEP", gltf.f32s("SCALAR", &[0.0, 1.0])),
    ];
    for (node, path, interpolation, output) in outputs {
        gltf.push(
            "animations",
            json!({
                "name": path,
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
                "samplers": [{ "input": times, "output": output, "interpolation": interpolation }],
            }),
        );
    }
    gltf.json["scenes"] = json!([{ "nodes": [0, 1, 3] }]);
    gltf.json["scene"] = json!(0);
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    gltf.json["buffers"] = json!([{ "byteLength": gltf.bin.len() }]);
    gltf
}

/// JSON pointers to every value below `value`.
fn pointers(value: &Value, at: &str, out: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(list) => list
            .iter()
            .enumerate()
            .map(|(place, value)| (place.to_string(), value))
            .collect(),
        _ => Vec::new(),
    };
    for (key, child) in children {
        let path = format!("{at}/{key}");
        pointers(child, &path, out);
        out.push(path);
    }
}

/// Ends with typed errors, at least one of them, or with an animation that keeps its guarantee.
fn check(gltf: &Gltf, what: &str) {
    match gltf.import() {
        Ok(imported) => {
            assert!(
                imported.faults.iter().all(|fault| fault.severity == Severity::Warning),
                "{what}"
            );
            keeps_guarantee(&imported.animation).unwrap_or_else(|broken| panic!("{what}: {broken}"));
        }
        Err(ImportError::Faults { faults, .. }) => {
            assert!(faults.iter().any(|fault| fault.severity == Severity::Error), "{what}");
        }
        Err(_) => {}
    }
}

#[test]
fn every_value_of_the_json_replaced() {
    let gltf = rich();
    gltf.clean();
    let mut paths = Vec::new();
    pointers(&gltf.json, "", &mut paths);
    assert!(paths.len() > 200, "{}", paths.len());
    let others = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(0.5),
        json!(1e31),
        json!(5121),
        json!(5126),
        json!(4_294_967_295u64),
        json!(u64::MAX),
        json!("x"),
        json!("MAT4"),
        json!([]),
        json!([0]),
        json!([0, 0, 0, 0]),
        json!({}),
    ];
    for path in &paths {
        for other in &others {
            let mut gltf = gltf.clone();
            *gltf.json.pointer_mut(path).unwrap() = other.clone();
            check(&gltf, &format!("{path} = {other}"));
        }
    }
}

#[test]
fn every_value_of_the_json_removed() {
    let gltf = rich();
    let mut paths = Vec::new();
    pointers(&gltf.json, "", &mut paths);
    for path in &paths {
        let mut gltf = gltf.clone();
        let (parent, key) = path.rsplit_once('/').unwrap();
        match gltf.json.pointer_mut(parent).unwrap() {
            Value::Object(map) => drop(map.remove(key)),
            Value::Array(list) => drop(list.remove(key.parse().unwrap())),
            other => panic!("{other}"),
        }
        check(&gltf, &format!("without {path}"));
    }
}

#[test]
fn every_byte_of_the_buffer_replaced() {
    let gltf = rich();
    for place in 0..gltf.bin.len() {
        for byte in [0, 1, 0x7F, 0x80, 0xFF] {
            let mut gltf = gltf.clone();
            gltf.bin[place] = byte;
            check(&gltf, &format!("byte {place} = {byte}"));
        }
    }
}

/// The guarantee of [`Animation`], spelt out.
fn keeps_guarantee(animation: &Animation) -> Result<(), String> {
    let expect = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    let usable = |values: &[f32]| values.iter().all(|value| value.abs() <= MAX_MAGNITUDE);
    let (nodes, meshes, skins) = (&animation.nodes, &animation.meshes, &animation.skins);
    for (number, node) in nodes.iter().enumerate() {
        match node.local {
            Local::Trs {
                translation,
                rotation,
                scale,
            } => {
                expect(usable(&translation) && usable(&scale), "translation or scale")?;
                let length: f32 = rotation.iter().map(|x| x * x).sum();
                // Normalised in f64, then rounded: each square is off by 2⁻²³ of itself at most.
                expect((length - 1.0).abs() < 1e-6, "rotation")?;
            }
            Local::Matrix(columns) => expect(usable(columns.as_flattened()), "matrix")?,
        }
        expect(usable(&node.weights), "node weights")?;
        let mut above = node.parent;
        for _ in 0..nodes.len() {
            expect(
                above.is_none_or(|parent| parent < nodes.len() && parent != number),
                "forest",
            )?;
            above = above.and_then(|parent| nodes[parent].parent);
        }
        expect(above.is_none(), "forest")?;
    }
    for primitive in meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let count = primitive.positions.len();
        expect(usable(primitive.positions.as_flattened()), "positions")?;
        expect(!primitive.triangles.is_empty(), "triangles")?;
        expect(
            primitive
                .triangles
                .as_flattened()
                .iter()
                .all(|corner| (*corner as usize) < count),
            "corners",
        )?;
        expect(
            primitive.influences.is_empty() || primitive.influences.len() == count,
            "influences",
        )?;
        for list in &primitive.influences {
            expect(
                !list.is_empty() && list.iter().all(|influence| influence.weight > 0.0),
                "weights",
            )?;
            expect(
                list.windows(2).all(|pair| pair[0].joint < pair[1].joint),
                "joints are distinct",
            )?;
        }
        for target in &primitive.morph_targets {
            expect(target.len() == count && usable(target.as_flattened()), "morph target")?;
        }
    }
    for mesh in meshes {
        let same = mesh
            .primitives
            .iter()
            .all(|primitive| primitive.morph_targets.len() == mesh.morph_target_count);
        expect(same, "morph target count")?;
    }
    for skin in skins {
        expect(
            !skin.joints.is_empty() && skin.joints.iter().all(|joint| *joint < nodes.len()),
            "joints",
        )?;
        expect(skin.inverse_bind.len() == skin.joints.len(), "inverse bind count")?;
        expect(usable(skin.inverse_bind.as_flattened().as_flattened()), "inverse bind")?;
    }
    for channel in animation.clips.iter().flat_map(|clip| &clip.channels) {
        channel_keeps_guarantee(animation, channel)?;
    }
    expect(!animation.parts.is_empty(), "parts")?;
    for part in &animation.parts {
        expect(part.node < nodes.len() && part.mesh < meshes.len(), "part")?;
        expect(
            nodes[part.node].weights.len() == meshes[part.mesh].morph_target_count,
            "default weights",
        )?;
        let Some(skin) = part.skin else { continue };
        expect(skin < skins.len(), "skin")?;
        for primitive in &meshes[part.mesh].primitives {
            expect(
                primitive.influences.len() == primitive.positions.len(),
                "influences under a skin",
            )?;
            let joints = primitive.influences.iter().flatten().map(|influence| influence.joint);
            expect(joints.max() < Some(skins[skin].joints.len()), "joint of a skin")?;
        }
    }
    Ok(())
}

fn channel_keeps_guarantee(animation: &Animation, channel: &Channel) -> Result<(), String> {
    let expect = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    expect(channel.node < animation.nodes.len(), "channel node")?;
    let node = &animation.nodes[channel.node];
    let width = match channel.target {
        ChannelTarget::Translation | ChannelTarget::Scale => 3,
        ChannelTarget::Rotation => 4,
        ChannelTarget::Weights => node.weights.len(),
    };
    let moves_transform = channel.target != ChannelTarget::Weights;
    expect(
        !moves_transform || matches!(node.local, Local::Trs { .. }),
        "an animated node has no matrix",
    )?;
    let count = channel.times.len() * channel.interpolation.values_per_key() as usize * width;
    expect(!channel.times.is_empty() && channel.values.len() == count, "values")?;
    expect(channel.times.windows(2).all(|pair| pair[0] < pair[1]), "key times")?;
    expect(
        channel
            .times
            .iter()
            .chain(&channel.values)
            .all(|value| value.abs() <= MAX_MAGNITUDE),
        "key numbers",
    )
}
