use restpose_formats::rows::Interpolation;
pub use restpose_formats::rows::Local;

/// An animated scene as its source describes it, decoded and checked but not yet decided upon.
///
/// Guarantee: every index is in range, nodes form a forest, every number is finite, influences are those of the source
/// (non-negative, with a positive sum, not yet renormalised), triangles are lists of three in winding order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// File name of the source, without its folder.
    pub source_name: String,
    /// BLAKE3 of the source file and every buffer it refers to.
    pub source_hash: [u8; 32],
    /// All nodes; an index here is the node's number in the source.
    pub nodes: Vec<Node>,
    /// All meshes; an index here is the mesh's number in the source.
    pub meshes: Vec<Mesh>,
    /// All skins; an index here is the skin's number in the source.
    pub skins: Vec<Skin>,
    /// All clips; an index here is the animation's number in the source.
    pub clips: Vec<Clip>,
    /// What the scene shows, in the order of the source's nodes.
    pub parts: Vec<Part>,
    /// All vertex caches; an index here is the cache's number in the source.
    pub caches: Vec<VertexCache>,
    /// Import options that changed what is here, as name and value: they are part of the bake's options.
    pub import_options: Vec<(String, String)>,
}

/// A vertex cache: where every point is in every frame. A clip plays it by a channel of [`ChannelTarget::Frame`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexCache {
    /// Points of one frame; at least one.
    pub point_count: usize,
    /// Positions in the space of the part's node, frame after frame: at least one frame of `point_count` points.
    pub positions: Vec<[f32; 3]>,
}

impl VertexCache {
    /// Number of frames.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.positions.len() / self.point_count.max(1)
    }

    /// The points of one frame.
    ///
    /// # Panics
    /// When there is no such frame.
    #[must_use]
    pub fn frame(&self, frame: usize) -> &[[f32; 3]] {
        &self.positions[frame * self.point_count..][..self.point_count]
    }
}

/// A node of the scene graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Empty where the source has none.
    pub name: String,
    /// Parent node.
    pub parent: Option<usize>,
    /// Parent from this node, without any clip. Rotations are normalised.
    pub local: Local,
    /// Morph weights without any clip: the node's, else its mesh's, else zeros; one per morph target of its mesh.
    pub weights: Vec<f32>,
}

/// A mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Empty where the source has none.
    pub name: String,
    /// Its primitives that have triangles.
    pub primitives: Vec<Primitive>,
    /// Morph targets that every primitive has.
    pub morph_target_count: usize,
}

/// The triangles of a mesh that share a vertex list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Its number in its mesh in the source.
    pub source_primitive: usize,
    /// Rest positions.
    pub positions: Vec<[f32; 3]>,
    /// Corners of each triangle; strips and fans unrolled as glTF 2.0 §3.7.2.1 orders them.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex, the skin joints that move it with a weight above zero, in rising order, each once; empty when the
    /// primitive has no joints or no node puts its mesh under a skin.
    pub influences: Vec<Vec<Influence>>,
    /// Per morph target, the displacement of each vertex.
    pub morph_targets: Vec<Vec<[f32; 3]>>,
    /// Per vertex, its point in the part's vertex cache, whose first frame is `positions`; empty without a cache.
    pub points: Vec<u32>,
}

/// The weight of one joint on one vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Index into [`Skin::joints`].
    pub joint: usize,
    /// Above zero, decoded, not renormalised.
    pub weight: f32,
}

/// A skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Empty where the source has none.
    pub name: String,
    /// Nodes.
    pub joints: Vec<usize>,
    /// Joint space from rest space, per joint: four columns of three. Identity where the source has none.
    pub inverse_bind: Vec<[[f32; 3]; 4]>,
}

/// An animation clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Empty where the source has none.
    pub name: String,
    /// In source order; a node and property appear at most once.
    pub channels: Vec<Channel>,
}

impl Clip {
    /// What the clip is called in options and in the file: its name, or its number in the source where it has none.
    #[must_use]
    pub fn label(&self, number: usize) -> String {
        if self.name.is_empty() {
            number.to_string()
        } else {
            self.name.clone()
        }
    }
}

/// One animated property.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Node that it moves; the vertex cache for [`ChannelTarget::Frame`].
    pub node: usize,
    /// Property that it moves.
    pub target: ChannelTarget,
    /// Between keys.
    pub interpolation: Interpolation,
    /// Key times, seconds; strictly increasing, at least one.
    pub times: Vec<f32>,
    /// `times.len() · values_per_key · width` values; normalised integers are decoded, rotations are as in the source.
    pub values: Vec<f32>,
}

/// A property that a channel moves.
pub use restpose_formats::rows::Path as ChannelTarget;

/// One node's mesh under that node's skin: the unit that is classed and reported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Node's name, else mesh's name, else `node N`.
    pub name: String,
    /// Node.
    pub node: usize,
    /// Mesh.
    pub mesh: usize,
    /// Skin. Where it is set every vertex has influences, and the node's own transform is ignored (glTF 2.0 §3.7.3.3).
    pub skin: Option<usize>,
    /// Vertex cache that gives the vertices' positions in every frame. No part has both a cache and a skin or morph
    /// targets.
    pub cache: Option<usize>,
}
