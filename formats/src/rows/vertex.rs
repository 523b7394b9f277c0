use bytemuck::{Pod, Zeroable};

/// Weights are whole multiples of this step, 2⁻²⁴, and those of one vertex sum to exactly one.
///
/// Every such weight is an `f32`, so the convex-combination argument behind the fuzzy boxes holds without a
/// rounding term.
pub const WEIGHT_STEP: f32 = 1.0 / (1u32 << 24) as f32;

/// A vertex of the rest pose. The section holds one row more than there are vertices: the last row's
/// `influence_first` is the influence count, so that every vertex's influences end where the next one's begin.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VertexRow {
    /// Rest position, in the space that the bones' `X` maps from. Zero in the closing row.
    pub position_rest: [f32; 3],
    /// First of this vertex's rows in the influence section; at least one row per vertex.
    pub influence_first: u32,
}

/// The weight with which one bone moves one vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct InfluenceRow {
    /// Bone row.
    pub bone: u32,
    /// In (0, 1], a multiple of [`WEIGHT_STEP`].
    pub weight: f32,
}

/// A triangle. Its row index is its id: parts, primitives and triangles stand in source order.
///
/// A triangle that is degenerate in every pose has three equal corners and is in no tree.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TriangleRow {
    /// Vertex rows, in winding order.
    pub corners: [u32; 3],
}
