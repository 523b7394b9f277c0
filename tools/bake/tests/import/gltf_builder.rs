//! Small glTF files, built in code.

use restpose_bake::import::{Animation, Fault, ImportError, Imported, Severity, import_gltf_bytes};
use serde_json::{Value, json};
use std::io;

pub const BYTE: u32 = 5120;
pub const UNSIGNED_BYTE: u32 = 5121;
pub const SHORT: u32 = 5122;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const UNSIGNED_INT: u32 = 5125;
pub const FLOAT: u32 = 5126;

/// A file in the making: JSON and the contents of its one buffer.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Gltf {
    /// Without any content.
    pub fn empty() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0" } }),
            bin: Vec::new(),
        }
    }

    /// One triangle in mesh 0, shown by node 0.
    pub fn triangle() -> Self {
        let mut gltf = Self::empty();
        let position = gltf.f32s("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        gltf.push(
            "meshes",
            json!({ "primitives": [{ "attributes": { "POSITION": position } }] }),
        );
        gltf.push("nodes", json!({ "mesh": 0 }));
        gltf
    }

    /// As [`Gltf::triangle`], its vertices on the joints 0, 1 and half of each; the joints are nodes 1 and 2.
    pub fn skinned() -> Self {
        let mut gltf = Self::triangle();
        let joints = gltf.accessor(UNSIGNED_BYTE, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
        let weights = gltf.f32s("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
        gltf.attributes()["JOINTS_0"] = json!(joints);
        gltf.attributes()["WEIGHTS_0"] = json!(weights);
        gltf.json["nodes"][0]["skin"] = json!(0);
        gltf.push("nodes", json!({ "children": [2] }));
        gltf.push("nodes", json!({ "translation": [0, 1, 0] }));
        gltf.push("skins", json!({ "joints": [1, 2] }));
        gltf
    }

    /// As [`Gltf::triangle`], node 0 moved by one channel.
    pub fn animated(path: &str, interpolation: &str, times: &[f32], shape: &str, values: &[f32]) -> Self {
        let mut gltf = Self::triangle();
        let (input, output) = (gltf.f32s("SCALAR", times), gltf.f32s(shape, values));
        gltf.push(
            "animations",
            json!({
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
                "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            }),
        );
        gltf
    }

    /// Attributes of the first primitive.
    pub fn attributes(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]["attributes"]
    }

    /// The first primitive.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Appends to a top-level array and gives the new element's number.
    pub fn push(&mut self, section: &str, value: Value) -> usize {
        let section = &mut self.json[section];
        if section.is_null() {
            *section = json!([]);
        }
        let array = section.as_array_mut().unwrap();
        array.push(value);
        array.len() - 1
    }

    /// A buffer view over new bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }),
        )
    }

    /// An accessor over new bytes.
    pub fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": count, "type": shape }),
        )
    }

    /// As [`Gltf::accessor`], marked as normalized.
    pub fn normalized(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let number = self.accessor(component, shape, count, bytes);
        self.json["accessors"][number]["normalized"] = json!(true);
        number
    }

    /// An accessor of floats.
    pub fn f32s(&mut self, shape: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(FLOAT, shape, values.len() / width(shape), &bytes)
    }

    /// An accessor of 16-bit integers.
    pub fn u16s(&mut self, shape: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(UNSIGNED_SHORT, shape, values.len() / width(shape), &bytes)
    }

    /// Bytes of the data of accessor 0's buffer view, to be overwritten.
    pub fn data_of(&mut self, accessor: usize) -> &mut [u8] {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        let start = self.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
        let length = self.json["bufferViews"][view]["byteLength"].as_u64().unwrap() as usize;
        &mut self.bin[start..start + length]
    }

    /// Overwrites one float of an accessor made by [`Gltf::f32s`].
    pub fn set_f32(&mut self, accessor: usize, place: usize, value: f32) {
        self.data_of(accessor)[4 * place..4 * place + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// The JSON, its buffer 0 described by `uri` if it is not that of a binary file.
    pub fn json_text(&self, uri: Option<&str>) -> String {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        if let Some(uri) = uri {
            json["buffers"][0]["uri"] = json!(uri);
        }
        json.to_string()
    }

    /// The bytes of a `.glb` file.
    pub fn glb(&self) -> Vec<u8> {
        glb(self.json_text(None).as_bytes(), &self.bin)
    }

    /// Imports the file as `.glb`.
    pub fn import(&self) -> Result<Imported, ImportError> {
        import_bytes(&self.glb())
    }

    /// Imports the file, which must succeed.
    pub fn imported(&self) -> Imported {
        self.import().unwrap_or_else(|error| panic!("{error:?}"))
    }

    /// Imports the file, which must succeed without warning.
    pub fn clean(&self) -> Animation {
        let imported = self.imported();
        assert_eq!(imported.faults, []);
        imported.animation
    }

    /// Imports the file, which must succeed with warnings at exactly these paths.
    pub fn warned(&self, paths: &[&str]) -> Animation {
        let imported = self.imported();
        assert!(imported.faults.iter().all(|fault| fault.severity == Severity::Warning));
        let found: Vec<_> = imported.faults.iter().map(|fault| fault.path.as_str()).collect();
        assert_eq!(found, paths, "{:?}", imported.faults);
        imported.animation
    }

    /// Errors of the import, which must fail with faults.
    pub fn errors(&self) -> Vec<Fault> {
        errors(self.import())
    }

    /// The import must fail with errors at exactly these paths. Gives the messages.
    pub fn refused(&self, paths: &[&str]) -> Vec<String> {
        let errors = self.errors();
        let found: Vec<_> = errors.iter().map(|fault| fault.path.as_str()).collect();
        assert_eq!(found, paths, "{errors:?}");
        errors.into_iter().map(|fault| fault.message).collect()
    }
}

/// Imports bytes of a file without buffers beside it.
pub fn import_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
    import_gltf_bytes("test.glb", bytes, &|uri| {
        Err(io::Error::new(io::ErrorKind::NotFound, uri.to_owned()))
    })
}

/// The faults of severity error.
pub fn errors(result: Result<Imported, ImportError>) -> Vec<Fault> {
    match result {
        Err(ImportError::Faults { faults, .. }) => faults
            .into_iter()
            .filter(|fault| fault.severity == Severity::Error)
            .collect(),
        other => panic!("expected faults, found {other:?}"),
    }
}

/// A binary container: JSON chunk padded with spaces, binary chunk padded with zeros.
pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut out = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    for word in [2, total as u32, json.len() as u32, 0x4E4F_534A] {
        out.extend(u32::to_le_bytes(word));
    }
    out.extend(json);
    for word in [bin.len() as u32, 0x004E_4942] {
        out.extend(u32::to_le_bytes(word));
    }
    out.extend(bin);
    out
}

fn width(shape: &str) -> usize {
    match shape {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        other => panic!("{other}"),
    }
}
