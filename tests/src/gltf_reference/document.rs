//! Reads a glTF file's JSON and buffers, and decodes them.

use super::{Channel, Interpolation, Mesh, Node, Primitive, Property, Reference, ReferencePart, Skin};
use nalgebra::{Matrix4, Vector3};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// A glTF file as read: its JSON and its buffers' bytes.
pub(super) struct Document {
    pub(super) json: Value,
    pub(super) buffers: Vec<Vec<u8>>,
}

impl Document {
    pub(super) fn read(path: &Path) -> Document {
        let read = |path: &Path| std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let bytes = read(path);
        let (json, mut binary) = match bytes.starts_with(b"glTF") {
            true => chunks(&bytes),
            false => (bytes.as_slice(), None),
        };
        let json: Value = serde_json::from_slice(json).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let buffers = list(&json, "buffers")
            .iter()
            .map(|buffer| match buffer["uri"].as_str() {
                Some(uri) => match uri.strip_prefix("data:").and_then(|data| data.split_once(";base64,")) {
                    Some((_, encoded)) => base64(encoded),
                    None => read(&path.with_file_name(uri)),
                },
                None => binary
                    .take()
                    .expect("a buffer without a uri is the binary chunk")
                    .to_vec(),
            });
        let buffers = buffers.collect();
        Document { json, buffers }
    }

    pub(super) fn decode(&self) -> Reference {
        for extension in list(&self.json, "extensionsRequired") {
            assert_eq!(
                extension, "KHR_mesh_quantization",
                "an extension that is not known here is required"
            );
        }
        let meshes: Vec<Mesh> = list(&self.json, "meshes").iter().map(|mesh| self.mesh(mesh)).collect();
        let nodes = self.nodes(&meshes);
        let reached = self.reached();
        let parts = reached.into_iter().filter_map(|node| {
            let json = &list(&self.json, "nodes")[node];
            let mesh = index(json, "mesh")?;
            let skin = index(json, "skin");
            Some(ReferencePart { node, mesh, skin })
        });
        Reference {
            parts: parts.collect(),
            skins: list(&self.json, "skins").iter().map(|skin| self.skin(skin)).collect(),
            clips: list(&self.json, "animations")
                .iter()
                .map(|clip| self.clip(clip))
                .collect(),
            meshes,
            nodes,
        }
    }

    fn nodes(&self, meshes: &[Mesh]) -> Vec<Node> {
        let all = list(&self.json, "nodes");
        let mut parents = vec![None; all.len()];
        for (parent, node) in all.iter().enumerate() {
            for child in list(node, "children") {
                parents[whole(child)] = Some(parent);
            }
        }
        let decoded = all.iter().zip(parents).map(|(node, parent)| {
            let or = |key: &str, default: &[f64]| numbers(node, key).unwrap_or_else(|| default.to_vec());
            let mesh = index(node, "mesh");
            let targets = mesh
                .and_then(|mesh| meshes[mesh].primitives.first())
                .map_or(0, |first| first.targets.len());
            let of_mesh = mesh.and_then(|mesh| numbers(&list(&self.json, "meshes")[mesh], "weights"));
            Node {
                parent,
                matrix: numbers(node, "matrix").map(|entries| Matrix4::from_column_slice(&entries)),
                translation: or("translation", &[0.0; 3]),
                rotation: or("rotation", &[0.0, 0.0, 0.0, 1.0]),
                scale: or("scale", &[1.0; 3]),
                weights: or("weights", &of_mesh.unwrap_or_else(|| vec![0.0; targets])),
            }
        });
        decoded.collect()
    }

    /// The nodes under the default scene; the first scene where none is marked, all nodes where there is none.
    fn reached(&self) -> BTreeSet<usize> {
        let nodes = list(&self.json, "nodes");
        let scene = list(&self.json, "scenes").get(index(&self.json, "scene").unwrap_or(0));
        let mut open: Vec<usize> = match scene {
            Some(scene) => list(scene, "nodes").iter().map(whole).collect(),
            None => (0..nodes.len()).collect(),
        };
        let mut reached = BTreeSet::new();
        while let Some(node) = open.pop() {
            if reached.insert(node) {
                open.extend(list(&nodes[node], "children").iter().map(whole));
            }
        }
        reached
    }

    fn mesh(&self, mesh: &Value) -> Mesh {
        let primitives = list(mesh, "primitives")
            .iter()
            .map(|primitive| self.primitive(primitive));
        Mesh {
            primitives: primitives.collect(),
        }
    }

    fn primitive(&self, primitive: &Value) -> Primitive {
        let attributes = &primitive["attributes"];
        let positions = match index(attributes, "POSITION") {
            Some(accessor) => self.vectors(accessor),
            None => Vec::new(),
        };
        let targets = list(primitive, "targets")
            .iter()
            .map(|target| match index(target, "POSITION") {
                Some(accessor) => self.vectors(accessor),
                None => vec![Vector3::zeros(); positions.len()],
            });
        let targets = targets.collect();
        let mut influences: Vec<Vec<(usize, f64)>> = Vec::new();
        for set in 0.. {
            let accessors =
                index(attributes, &format!("JOINTS_{set}")).zip(index(attributes, &format!("WEIGHTS_{set}")));
            let Some((joints, weights)) = accessors else {
                break;
            };
            influences.resize(positions.len(), Vec::new());
            let rows = self.rows(joints).into_iter().zip(self.rows(weights));
            for (vertex, (joints, weights)) in rows.enumerate() {
                influences[vertex].extend(joints.iter().map(|&joint| joint as usize).zip(weights));
            }
        }
        let order: Vec<usize> = match index(primitive, "indices") {
            Some(accessor) => self.rows(accessor).iter().map(|row| row[0] as usize).collect(),
            None => (0..positions.len()).collect(),
        };
        let triangles = unrolled(index(primitive, "mode").unwrap_or(4), &order);
        Primitive {
            positions,
            targets,
            influences,
            triangles,
        }
    }

    fn skin(&self, skin: &Value) -> Skin {
        let joints: Vec<usize> = list(skin, "joints").iter().map(whole).collect();
        let inverse_bind = match index(skin, "inverseBindMatrices") {
            Some(accessor) => self
                .rows(accessor)
                .iter()
                .map(|row| Matrix4::from_column_slice(row))
                .collect(),
            None => vec![Matrix4::identity(); joints.len()],
        };
        assert!(
            inverse_bind.len() >= joints.len(),
            "a joint without an inverse bind matrix"
        );
        Skin { joints, inverse_bind }
    }

    fn clip(&self, clip: &Value) -> Vec<Channel> {
        let channels = list(clip, "channels").iter();
        // A channel without a node is an extension's affair (§5.5).
        channels
            .filter_map(|channel| Some(self.channel(clip, channel, index(&channel["target"], "node")?)))
            .collect()
    }

    fn channel(&self, clip: &Value, channel: &Value, node: usize) -> Channel {
        let sampler = &list(clip, "samplers")[whole(&channel["sampler"])];
        let times: Vec<f64> = self.rows(whole(&sampler["input"])).concat();
        let values: Vec<f64> = self.rows(whole(&sampler["output"])).concat();
        let interpolation = match sampler["interpolation"].as_str().unwrap_or("LINEAR") {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            other => panic!("interpolation {other}"),
        };
        let property = match channel["target"]["path"].as_str() {
            Some("translation") => Property::Translation,
            Some("rotation") => Property::Rotation,
            Some("scale") => Property::Scale,
            Some("weights") => Property::Weights,
            other => panic!("path {other:?}"),
        };
        let elements = if interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        } * times.len();
        assert!(elements > 0, "a channel without keys");
        assert_eq!(
            values.len() % elements,
            0,
            "{} values for {} keys",
            values.len(),
            times.len()
        );
        let width = values.len() / elements;
        Channel {
            node,
            property,
            interpolation,
            times,
            width,
            values,
        }
    }

    fn vectors(&self, accessor: usize) -> Vec<Vector3<f64>> {
        self.rows(accessor)
            .iter()
            .map(|row| Vector3::from_row_slice(row))
            .collect()
    }

    /// An accessor's elements, sparse ones put in place and normalised integers as fractions (§3.6.2).
    pub(super) fn rows(&self, accessor: usize) -> Vec<Vec<f64>> {
        let accessor = &list(&self.json, "accessors")[accessor];
        let component = whole(&accessor["componentType"]);
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            Some("MAT4") => 16,
            other => panic!("accessor type {other:?}"),
        };
        let count = whole(&accessor["count"]);
        let mut rows = match index(accessor, "bufferView") {
            Some(view) => self.view_rows(view, index(accessor, "byteOffset"), component, width, count),
            None => vec![vec![0.0; width]; count],
        };
        let sparse = &accessor["sparse"];
        if sparse.is_object() {
            let (replaced, indices, values) = (whole(&sparse["count"]), &sparse["indices"], &sparse["values"]);
            let of = |part: &Value, component: usize, width: usize| {
                self.view_rows(
                    whole(&part["bufferView"]),
                    index(part, "byteOffset"),
                    component,
                    width,
                    replaced,
                )
            };
            let places = of(indices, whole(&indices["componentType"]), 1);
            for (place, value) in places.iter().zip(of(values, component, width)) {
                rows[place[0] as usize] = value;
            }
        }
        if accessor["normalized"] == true {
            let full = match component {
                5120 => 127.0,
                5121 => 255.0,
                5122 => 32_767.0,
                5123 => 65_535.0,
                other => panic!("component type {other} cannot be normalised"),
            };
            rows.iter_mut()
                .flatten()
                .for_each(|value| *value = (*value / full).max(-1.0));
        }
        rows
    }

    fn view_rows(
        &self,
        view: usize,
        offset: Option<usize>,
        component: usize,
        width: usize,
        count: usize,
    ) -> Vec<Vec<f64>> {
        let view = &list(&self.json, "bufferViews")[view];
        let start = index(view, "byteOffset").unwrap_or(0) + offset.unwrap_or(0);
        let buffer = &self.buffers[whole(&view["buffer"])];
        let size = match component {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            other => panic!("component type {other}"),
        };
        let stride = index(view, "byteStride").unwrap_or(size * width);
        let number = |row: usize, column: usize| -> f64 {
            let at = start + row * stride + column * size;
            let mut bytes = [0; 4];
            bytes[..size].copy_from_slice(&buffer[at..at + size]);
            match component {
                5120 => f64::from(bytes[0] as i8),
                5121 => f64::from(bytes[0]),
                5122 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
                5123 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                5125 => f64::from(u32::from_le_bytes(bytes)),
                _ => f64::from(f32::from_le_bytes(bytes)),
            }
        };
        (0..count)
            .map(|row| (0..width).map(|column| number(row, column)).collect())
            .collect()
    }
}

/// Triangles of a list, strip or fan, in the order of §3.7.2.1.
pub(super) fn unrolled(mode: usize, order: &[usize]) -> Vec<[usize; 3]> {
    let places: Vec<[usize; 3]> = match mode {
        4 => (0..order.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        5 => (0..order.len().saturating_sub(2))
            .map(|i| [i, i + 1 + i % 2, i + 2 - i % 2])
            .collect(),
        6 => (0..order.len().saturating_sub(2)).map(|i| [i + 1, i + 2, 0]).collect(),
        _ => Vec::new(),
    };
    places
        .into_iter()
        .map(|corners| corners.map(|place| order[place]))
        .collect()
}

/// The JSON and the binary chunk of a `.glb` (§4.4).
fn chunks(bytes: &[u8]) -> (&[u8], Option<&[u8]>) {
    let word = |at: usize| {
        bytes[at..at + 4]
            .iter()
            .rev()
            .fold(0, |sum, &byte| sum << 8 | usize::from(byte))
    };
    assert_eq!(word(4), 2, "version of the container");
    let json = 20..20 + word(12);
    let binary = json.end;
    let length = (binary + 8 <= bytes.len()).then(|| word(binary));
    (
        &bytes[json],
        length.map(|length| &bytes[binary + 8..binary + 8 + length]),
    )
}

/// Decodes base64 as RFC 4648, section 4, has it.
pub(super) fn base64(text: &str) -> Vec<u8> {
    const ALPHABET: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = text.bytes().filter(|&byte| byte != b'=').map(|byte| {
        let digit = ALPHABET.iter().position(|&letter| letter == byte);
        digit.unwrap_or_else(|| panic!("{:?} is no base64 digit", char::from(byte))) as u32
    });
    let digits: Vec<u32> = digits.collect();
    let decode = |four: &[u32]| {
        let bits = (0..4).fold(0, |bits, place| bits << 6 | four.get(place).copied().unwrap_or(0));
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    digits.chunks(4).flat_map(decode).collect()
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn index(value: &Value, key: &str) -> Option<usize> {
    value[key].as_u64().map(|number| number as usize)
}

fn whole(value: &Value) -> usize {
    value
        .as_u64()
        .unwrap_or_else(|| panic!("{value} where a whole number was expected")) as usize
}

/// Numbers of the JSON as written, which may be finer than f32.
fn numbers(value: &Value, key: &str) -> Option<Vec<f64>> {
    let list = value[key].as_array()?;
    let number = |value: &Value| {
        value
            .as_f64()
            .unwrap_or_else(|| panic!("{value} where a number was expected"))
    };
    Some(list.iter().map(number).collect())
}
