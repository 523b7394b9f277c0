use bytemuck::{Pod, Zeroable};

/// The morph targets of one node. An instance has one weight per target row of the file.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct MorphSetRow {
    /// Number of the node in the source file.
    pub source_node: u32,
    /// First morph target row.
    pub target_first: u32,
    /// Morph target rows.
    pub target_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// One morph target of one node.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MorphTargetRow {
    /// Weight where no clip sets one.
    pub default_weight: f32,
    /// Largest `|delta|` of the target per axis; bounds how far a weight can move a vertex.
    pub extent: [f32; 3],
}

/// What one morph target adds to one vertex at weight one. A vertex's deltas are found by the morph-first
/// section: empty when the file has no deltas, else one row per vertex and a closing one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MorphDeltaRow {
    /// Morph target row.
    pub target: u32,
    /// Displacement in rest space.
    pub delta: [f32; 3],
}
