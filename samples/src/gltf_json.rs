//! The objects of a glTF 2.0 document (§5 of its specification), as far as the samples use them.
//!
//! Fields are written in the order in which they stand here, and left out where the specification has a default.

use serde::Serialize;
use std::collections::BTreeMap;

/// The root object.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    /// Version and generator.
    pub asset: Asset,
    /// Extensions used somewhere in the file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_used: Vec<String>,
    /// Extensions without which the file cannot be read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_required: Vec<String>,
    /// Default scene.
    pub scene: usize,
    /// Scenes.
    pub scenes: Vec<Scene>,
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Meshes.
    pub meshes: Vec<Mesh>,
    /// Materials.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<Material>,
    /// Skins.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub skins: Vec<Skin>,
    /// Animations.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub animations: Vec<Animation>,
    /// Accessors.
    pub accessors: Vec<Accessor>,
    /// Buffer views.
    pub buffer_views: Vec<BufferView>,
    /// Buffers.
    pub buffers: Vec<Buffer>,
}

/// What wrote the file and for which version.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Asset {
    /// glTF version.
    pub version: String,
    /// Program that wrote the file.
    pub generator: String,
}

/// The root nodes that are shown together.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Scene {
    /// Name.
    pub name: String,
    /// Root nodes.
    pub nodes: Vec<usize>,
}

/// A node: `matrix` or any of translation, rotation (x, y, z, w) and scale.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    /// Skin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin: Option<usize>,
    /// Parent from node, column-major.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f32; 16]>,
    /// Translation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f32; 3]>,
    /// Unit quaternion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f32; 4]>,
    /// Scale along the node's axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f32; 3]>,
    /// Morph weights in place of the mesh's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<f32>,
    /// Child nodes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<usize>,
}

/// A mesh.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Mesh {
    /// Name.
    pub name: String,
    /// Primitives.
    pub primitives: Vec<Primitive>,
    /// Morph weights.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<f32>,
    /// Names of the morph targets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<MeshExtras>,
}

/// The customary place for morph target names.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MeshExtras {
    /// One name per morph target.
    pub target_names: Vec<String>,
}

/// Topology: triangles.
pub const TRIANGLES: u32 = 4;
/// Topology: triangle strip.
pub const TRIANGLE_STRIP: u32 = 5;
/// Topology: triangle fan.
pub const TRIANGLE_FAN: u32 = 6;

/// The part of a mesh with one material and one vertex list.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Primitive {
    /// Accessor per attribute.
    pub attributes: BTreeMap<String, usize>,
    /// Accessor of the vertex numbers; without it the vertices are taken in order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub indices: Option<usize>,
    /// Material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<usize>,
    /// Topology; triangles where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Accessor per attribute, per morph target.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<BTreeMap<String, usize>>,
}

/// A material.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    /// Name.
    pub name: String,
    /// Colour.
    pub pbr_metallic_roughness: PbrMetallicRoughness,
}

/// The colour of a material.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PbrMetallicRoughness {
    /// Linear red, green, blue, alpha.
    pub base_color_factor: [f32; 4],
    /// 0 is a dielectric, 1 a metal.
    pub metallic_factor: f32,
    /// 0 is smooth, 1 is rough.
    pub roughness_factor: f32,
}

/// A skin.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Skin {
    /// Name.
    pub name: String,
    /// Accessor of one matrix per joint.
    pub inverse_bind_matrices: usize,
    /// The joints' common root.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<usize>,
    /// Nodes.
    pub joints: Vec<usize>,
}

/// A clip.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Animation {
    /// Name.
    pub name: String,
    /// What moves.
    pub channels: Vec<Channel>,
    /// How it moves.
    pub samplers: Vec<Sampler>,
}

/// One animated property.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Channel {
    /// Index into the clip's samplers.
    pub sampler: usize,
    /// Property.
    pub target: ChannelTarget,
}

/// A property of a node.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ChannelTarget {
    /// Node.
    pub node: usize,
    /// `translation`, `rotation`, `scale` or `weights`.
    pub path: &'static str,
}

/// Keys.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Sampler {
    /// Accessor of the times.
    pub input: usize,
    /// `LINEAR`, `STEP` or `CUBICSPLINE`.
    pub interpolation: &'static str,
    /// Accessor of the values.
    pub output: usize,
}

/// A typed view of a buffer view.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    /// Buffer view; zeros where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<usize>,
    /// Bytes into the buffer view.
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: usize,
    /// Component type code.
    pub component_type: u32,
    /// Whether integers stand for fractions.
    #[serde(skip_serializing_if = "is_false")]
    pub normalized: bool,
    /// Number of elements.
    pub count: usize,
    /// `SCALAR`, `VEC3`, `VEC4` or `MAT4`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Largest value per component, as stored.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub max: Vec<Number>,
    /// Smallest value per component, as stored.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub min: Vec<Number>,
    /// Elements that differ from the buffer view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sparse: Option<Sparse>,
}

/// A bound of an accessor, written like the component that it bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Number {
    /// Of a float accessor.
    Float(f32),
    /// Of an integer accessor.
    Integer(i64),
}

/// Elements that replace those of the accessor.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Sparse {
    /// Number of replaced elements.
    pub count: usize,
    /// Which elements.
    pub indices: SparseIndices,
    /// Their values.
    pub values: SparseValues,
}

/// Strictly increasing element numbers.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    /// Buffer view.
    pub buffer_view: usize,
    /// Component type code.
    pub component_type: u32,
}

/// Values in the accessor's own type.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    /// Buffer view.
    pub buffer_view: usize,
}

/// A range of a buffer.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    /// Buffer.
    pub buffer: usize,
    /// Bytes into the buffer.
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: usize,
    /// Length.
    pub byte_length: usize,
    /// Distance between vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_stride: Option<usize>,
    /// 34962 for vertices, 34963 for vertex numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

/// Binary data.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    /// Where it is; left out for the binary chunk of a `.glb`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    /// Length.
    pub byte_length: usize,
}

fn is_zero(value: &usize) -> bool {
    *value == 0
}

fn is_false(value: &bool) -> bool {
    !*value
}
