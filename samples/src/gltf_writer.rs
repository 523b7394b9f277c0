//! Collects buffers, accessors and objects, and writes them as `.glb`, or as `.gltf` with its buffer inside or beside it.

use crate::column::{Column, Component, narrow};
use crate::gltf_json::{
    Accessor, Animation, Asset, Buffer, BufferView, Channel, ChannelTarget, Document, Material, Mesh, Node, Number,
    PbrMetallicRoughness, Primitive, Sampler, Scene, Skin, Sparse, SparseIndices, SparseValues,
};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::collections::BTreeMap;

const VERTICES: Option<u32> = Some(34962);
const VERTEX_NUMBERS: Option<u32> = Some(34963);

/// A glTF document in the making, with one buffer.
#[derive(Clone, Debug)]
pub struct GltfWriter {
    document: Document,
    buffer: Vec<u8>,
}

impl GltfWriter {
    /// An empty scene of the given name.
    pub fn new(scene_name: &str) -> GltfWriter {
        let document = Document {
            asset: Asset {
                version: "2.0".to_owned(),
                generator: "restpose-samples".to_owned(),
            },
            scenes: vec![Scene {
                name: scene_name.to_owned(),
                nodes: Vec::new(),
            }],
            ..Document::default()
        };
        GltfWriter {
            document,
            buffer: Vec::new(),
        }
    }

    /// Says that the file cannot be read without an extension.
    pub fn require_extension(&mut self, name: &str) {
        self.document.extensions_used.push(name.to_owned());
        self.document.extensions_required.push(name.to_owned());
    }

    /// Adds a node that is nobody's child to the scene.
    pub fn add_root(&mut self, node: Node) -> usize {
        let index = self.add_node(node);
        self.document.scenes[0].nodes.push(index);
        index
    }

    /// Adds a node; a parent's `children` or [`GltfWriter::add_child`] must name it.
    pub fn add_node(&mut self, node: Node) -> usize {
        self.document.nodes.push(node);
        self.document.nodes.len() - 1
    }

    /// Adds a node under another one.
    pub fn add_child(&mut self, parent: usize, node: Node) -> usize {
        let index = self.add_node(node);
        self.document.nodes[parent].children.push(index);
        index
    }

    /// Adds a mesh.
    pub fn add_mesh(&mut self, mesh: Mesh) -> usize {
        self.document.meshes.push(mesh);
        self.document.meshes.len() - 1
    }

    /// Adds a skin.
    pub fn add_skin(&mut self, skin: Skin) -> usize {
        self.document.skins.push(skin);
        self.document.skins.len() - 1
    }

    /// Adds a rough, opaque material of a linear colour.
    pub fn add_material(&mut self, name: &str, [red, green, blue]: [f32; 3]) -> usize {
        self.document.materials.push(Material {
            name: name.to_owned(),
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: [red, green, blue, 1.0],
                metallic_factor: 0.0,
                roughness_factor: 0.8,
            },
        });
        self.document.materials.len() - 1
    }

    /// Adds vertex attributes, each in its own buffer view, rows padded to four bytes.
    pub fn add_attributes(&mut self, columns: &[(&str, Column)]) -> BTreeMap<String, usize> {
        columns
            .iter()
            .map(|(name, column)| {
                let one = std::slice::from_ref(column);
                ((*name).to_owned(), self.add_rows(one)[0])
            })
            .collect()
    }

    /// Adds vertex attributes in one buffer view, vertex by vertex.
    pub fn add_interleaved(&mut self, columns: &[(&str, Column)]) -> BTreeMap<String, usize> {
        let only_columns: Vec<_> = columns.iter().map(|(_, column)| column.clone()).collect();
        let accessors = self.add_rows(&only_columns);
        let names = columns.iter().map(|(name, _)| (*name).to_owned());
        names.zip(accessors).collect()
    }

    /// Columns side by side in one buffer view; every column starts on four bytes within the row.
    fn add_rows(&mut self, columns: &[Column]) -> Vec<usize> {
        let widths: Vec<_> = columns
            .iter()
            .map(|column| column.row_bytes().next_multiple_of(4))
            .collect();
        let count = columns.iter().map(|column| column.count).max().unwrap_or(0);
        let mut bytes = Vec::new();
        for row in 0..count {
            for (column, width) in columns.iter().zip(&widths) {
                let length = column.row_bytes();
                bytes.extend_from_slice(&column.bytes[row * length..(row + 1) * length]);
                bytes.resize(bytes.len() + width - length, 0);
            }
        }
        let stride: usize = widths.iter().sum();
        let packed = columns.len() == 1 && columns[0].row_bytes() == stride;
        let view = self.add_view(&bytes, VERTICES, (!packed).then_some(stride));
        let mut byte_offset = 0;
        let mut accessors = Vec::new();
        for (column, width) in columns.iter().zip(widths) {
            accessors.push(self.push_accessor(column, Some(view), byte_offset));
            byte_offset += width;
        }
        accessors
    }

    /// Adds vertex numbers.
    pub fn add_indices(&mut self, values: &[u32], at_least: Component) -> usize {
        let column = Column::indices(values, at_least);
        let view = self.add_view(&column.bytes, VERTEX_NUMBERS, None);
        self.push_accessor(&column, Some(view), 0)
    }

    /// Adds numbers that are neither vertices nor vertex numbers.
    pub fn add_column(&mut self, column: &Column) -> usize {
        let view = self.add_view(&column.bytes, None, None);
        self.push_accessor(column, Some(view), 0)
    }

    /// Adds displacements of which only the rows that are not zero are stored.
    pub fn add_sparse_displacements(&mut self, rows: &[[f32; 3]]) -> usize {
        let moved: Vec<usize> = (0..rows.len()).filter(|&row| rows[row] != [0.0; 3]).collect();
        let numbers: Vec<_> = moved.iter().map(|&row| [row as i64]).collect();
        let values: Vec<_> = moved.iter().map(|&row| rows[row]).collect();
        let numbers = Column::integers(Component::U16, false, &numbers);
        let indices = SparseIndices {
            buffer_view: self.add_view(&numbers.bytes, None, None),
            component_type: numbers.component.code(),
        };
        let values = SparseValues {
            buffer_view: self.add_view(&Column::floats(&values).bytes, None, None),
        };
        let accessor = self.push_accessor(&Column::floats(rows), None, 0);
        self.document.accessors[accessor].sparse = Some(Sparse {
            count: moved.len(),
            indices,
            values,
        });
        accessor
    }

    fn add_view(&mut self, bytes: &[u8], target: Option<u32>, stride: Option<usize>) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.document.buffer_views.push(BufferView {
            buffer: 0,
            byte_offset: self.buffer.len(),
            byte_length: bytes.len(),
            byte_stride: stride,
            target,
        });
        self.buffer.extend_from_slice(bytes);
        self.document.buffer_views.len() - 1
    }

    fn push_accessor(&mut self, column: &Column, view: Option<usize>, byte_offset: usize) -> usize {
        // Bounds of sixteen matrix entries would say nothing.
        let bounds: &[(Number, Number)] = match column.kind {
            "MAT4" => &[],
            _ => &column.bounds,
        };
        self.document.accessors.push(Accessor {
            buffer_view: view,
            byte_offset,
            component_type: column.component.code(),
            normalized: column.normalized,
            count: column.count,
            kind: column.kind,
            max: bounds.iter().map(|&(_, high)| high).collect(),
            min: bounds.iter().map(|&(low, _)| low).collect(),
            sparse: None,
        });
        self.document.accessors.len() - 1
    }

    /// Adds a clip; tracks with equal times share them.
    pub fn add_clip(&mut self, name: &str, tracks: &[Track]) -> usize {
        let mut animation = Animation {
            name: name.to_owned(),
            ..Animation::default()
        };
        let mut inputs: Vec<(&[f64], usize)> = Vec::new();
        for track in tracks {
            let known = inputs.iter().find(|(times, _)| *times == track.times);
            let input = match known {
                Some(&(_, accessor)) => accessor,
                None => {
                    let accessor = self.add_column(&Column::scalars(&track.times));
                    inputs.push((&track.times, accessor));
                    accessor
                }
            };
            animation.channels.push(Channel {
                sampler: animation.samplers.len(),
                target: ChannelTarget {
                    node: track.node,
                    path: track.path,
                },
            });
            animation.samplers.push(Sampler {
                input,
                interpolation: track.interpolation,
                output: self.add_column(&track.values),
            });
        }
        self.document.animations.push(animation);
        self.document.animations.len() - 1
    }

    /// The binary form: JSON and buffer in one file.
    ///
    /// # Errors
    /// [`WriteError`] where the JSON cannot be written or the file would exceed the format's 32-bit lengths.
    pub fn into_glb(mut self) -> Result<Vec<u8>, WriteError> {
        self.finish(None);
        let mut json = serde_json::to_vec(&self.document)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() + 8 + self.buffer.len();
        let mut file = Vec::with_capacity(length);
        file.extend_from_slice(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend(length_field(length)?);
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.buffer)] {
            file.extend(length_field(chunk.len())?);
            file.extend_from_slice(kind);
            file.extend_from_slice(chunk);
        }
        Ok(file)
    }

    /// The text form with the buffer as a data URI.
    ///
    /// # Errors
    /// [`WriteError`] where the JSON cannot be written.
    pub fn into_embedded_gltf(mut self) -> Result<Vec<u8>, WriteError> {
        let encoded = STANDARD.encode(&self.buffer);
        self.finish(Some(format!("data:application/octet-stream;base64,{encoded}")));
        self.text()
    }

    /// The text form and the buffer that lies beside it under `uri`.
    ///
    /// # Errors
    /// [`WriteError`] where the JSON cannot be written.
    pub fn into_gltf_and_buffer(mut self, uri: &str) -> Result<(Vec<u8>, Vec<u8>), WriteError> {
        self.finish(Some(uri.to_owned()));
        Ok((self.text()?, self.buffer))
    }

    fn text(&self) -> Result<Vec<u8>, WriteError> {
        let mut text = serde_json::to_vec_pretty(&self.document)?;
        text.push(b'\n');
        Ok(text)
    }

    fn finish(&mut self, uri: Option<String>) {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.document.buffers = vec![Buffer {
            uri,
            byte_length: self.buffer.len(),
        }];
    }
}

fn length_field(length: usize) -> Result<[u8; 4], WriteError> {
    u32::try_from(length)
        .map(u32::to_le_bytes)
        .map_err(|_| WriteError::TooLong { length })
}

/// The keys of one property of one node.
#[derive(Clone, Debug)]
pub struct Track {
    /// Node.
    pub node: usize,
    /// `translation`, `rotation`, `scale` or `weights`.
    pub path: &'static str,
    /// `LINEAR`, `STEP` or `CUBICSPLINE`.
    pub interpolation: &'static str,
    /// Seconds, strictly increasing.
    pub times: Vec<f64>,
    /// One value per key; three (in-tangent, value, out-tangent) for a cubic spline.
    pub values: Column,
}

/// In-tangent, value and out-tangent per key, with the tangents of the parabola through each key and its neighbours;
/// the two end keys rest.
///
/// Shapes: `values` is `[key]`, each of N numbers; the result is `[3 · key]`.
pub fn with_tangents<const N: usize>(times: &[f64], values: &[[f64; N]]) -> Vec<[f32; N]> {
    let mut rows = Vec::with_capacity(values.len() * 3);
    for key in 0..values.len() {
        let mut tangent = [0.0; N];
        if key > 0 && key + 1 < values.len() {
            let (before, after) = (times[key] - times[key - 1], times[key + 1] - times[key]);
            for (component, slope) in tangent.iter_mut().enumerate() {
                let rise = |from: usize| values[from + 1][component] - values[from][component];
                let (left, right) = (rise(key - 1) / before, rise(key) / after);
                *slope = (left * after + right * before) / (before + after);
            }
        }
        let tangent = tangent.map(narrow);
        rows.extend([tangent, values[key].map(narrow), tangent]);
    }
    rows
}

/// A primitive with the given attributes and nothing else.
pub fn primitive(attributes: BTreeMap<String, usize>) -> Primitive {
    Primitive {
        attributes,
        ..Primitive::default()
    }
}

/// Why a scene could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The JSON could not be written.
    #[error("the scene's JSON could not be written: {0}")]
    Json(#[from] serde_json::Error),
    /// A length does not fit the 32 bits that the binary form has for it.
    #[error("{length} bytes do not fit the 32-bit lengths of a .glb file; write a .gltf with a buffer beside it")]
    TooLong {
        /// Bytes.
        length: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangents_of_a_parabola_are_its_slopes() {
        let times = [0.0, 1.0, 3.0, 4.0];
        let values = times.map(|time| [time * time]);
        let rows = with_tangents(&times, &values);
        assert_eq!(rows[3], [2.0]);
        assert_eq!(rows[4], [1.0]);
        assert_eq!(rows[6], [6.0]);
        assert_eq!(rows[0], [0.0]);
    }

    #[test]
    fn glb_starts_with_its_length() {
        let file = GltfWriter::new("empty").into_glb();
        let file = file.expect("an empty document is written");
        assert_eq!(&file[..4], b"glTF");
        assert_eq!(file[8..12], (file.len() as u32).to_le_bytes());
        assert_eq!(file.len() % 4, 0);
    }
}
