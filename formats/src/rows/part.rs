use bytemuck::{Pod, Zeroable};

/// How a part moves; decides what is stored of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum MotionClass {
    /// No vertex moves.
    Static = 0,
    /// Every triangle follows one bone exactly.
    Rigid = 1,
    /// Some vertex blends several bones, or morphs.
    Skinned = 2,
    /// A vertex cache moves the vertices, coherently enough for clusters with fuzzy trees.
    Keyframed = 3,
    /// A vertex cache moves the vertices; its tree is built afresh in every frame.
    Free = 4,
}

impl MotionClass {
    /// All classes, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Static, Self::Rigid, Self::Skinned, Self::Keyframed, Self::Free];

    /// The class with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|class| *class as u32 == number)
    }

    /// The class's name, as reports print it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Rigid => "rigid",
            Self::Skinned => "skinned",
            Self::Keyframed => "keyframed",
            Self::Free => "free",
        }
    }
}

/// A part: one node's mesh, under that node's skin if it has one. Its name is in the metadata.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PartRow {
    /// Number of the node in the source file.
    pub source_node: u32,
    /// Number of the mesh in the source file.
    pub source_mesh: u32,
    /// Number of the skin in the source file, or `NONE`.
    pub source_skin: u32,
    /// [`MotionClass`] as a number.
    pub class: u32,
    /// First vertex row.
    pub vertex_first: u32,
    /// Vertex rows.
    pub vertex_count: u32,
    /// First triangle row.
    pub triangle_first: u32,
    /// Triangle rows.
    pub triangle_count: u32,
    /// First primitive row.
    pub primitive_first: u32,
    /// Primitive rows.
    pub primitive_count: u32,
    /// Morph set row that moves this part's vertices, or `NONE`.
    pub morph_set: u32,
    /// Cache row that moves this part's vertices, or `NONE`.
    pub cache: u32,
}

/// One primitive of a part's mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PrimitiveRow {
    /// Number of the primitive in its mesh in the source file.
    pub source_primitive: u32,
    /// First triangle row; the source's triangle number is a triangle's row minus this.
    pub triangle_first: u32,
    /// Triangle rows.
    pub triangle_count: u32,
    /// Zero.
    pub reserved: u32,
}
