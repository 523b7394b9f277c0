use crate::geom::Affine;
use bytemuck::{Pod, Zeroable};

/// Bone 0 is the asset itself: no node, identity. Static triangles hang on it.
pub const ROOT_BONE: u32 = 0;

/// A node that some bone needs. Parents stand before their children.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct NodeRow {
    /// Node row of the parent, less than this row's own index, or `NONE`.
    pub parent: u32,
    /// Number of the node in the source file.
    pub source_node: u32,
    /// 0: `local` is translation (3), rotation quaternion x y z w (4), scale (3), two zeros.
    /// 1: `local` is four columns of three, as [`crate::geom::Affine`]; no channel may move such a node.
    pub local_kind: u32,
    /// Zero.
    pub reserved: u32,
    /// Parent from this node, where no clip says otherwise.
    pub local: [f32; 12],
}

/// A node's local map, decoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Local {
    /// Scale first, then rotation, then translation.
    Trs {
        /// Translation.
        translation: [f32; 3],
        /// Quaternion x, y, z, w; normalised when used.
        rotation: [f32; 4],
        /// Scale per axis.
        scale: [f32; 3],
    },
    /// Any affine map.
    Matrix([[f32; 3]; 4]),
}

impl NodeRow {
    /// `local_kind` of translation, rotation and scale.
    pub const TRS: u32 = 0;
    /// `local_kind` of a matrix.
    pub const MATRIX: u32 = 1;

    /// A row with this local map.
    #[must_use]
    pub fn new(parent: u32, source_node: u32, local: Local) -> Self {
        let mut row = Self {
            parent,
            source_node,
            local_kind: Self::TRS,
            reserved: 0,
            local: [0.0; 12],
        };
        match local {
            Local::Trs {
                translation,
                rotation,
                scale,
            } => {
                row.local[..3].copy_from_slice(&translation);
                row.local[3..7].copy_from_slice(&rotation);
                row.local[7..10].copy_from_slice(&scale);
            }
            Local::Matrix(columns) => {
                row.local_kind = Self::MATRIX;
                row.local = bytemuck::cast(columns);
            }
        }
        row
    }

    /// The local map, decoded. `local_kind` has been checked when the file was opened.
    #[inline]
    #[must_use]
    pub fn local(&self) -> Local {
        let l = &self.local;
        if self.local_kind == Self::MATRIX {
            Local::Matrix(bytemuck::cast(self.local))
        } else {
            Local::Trs {
                translation: [l[0], l[1], l[2]],
                rotation: [l[3], l[4], l[5], l[6]],
                scale: [l[7], l[8], l[9]],
            }
        }
    }
}

/// A bone: one entry of the palette. `X = world(node) · inverse_bind`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BoneRow {
    /// Node row, or `NONE` for the root bone.
    pub node: u32,
    /// Number of the skin in the source file, or `NONE` for a bone that carries a rigid part.
    pub source_skin: u32,
    /// Number of the joint in that skin, or `NONE`.
    pub source_joint: u32,
    /// Zero.
    pub reserved: u32,
    /// Node space from rest space: four columns of three, as [`crate::geom::Affine`].
    pub inverse_bind: [f32; 12],
}

impl BoneRow {
    /// The inverse bind map: a palette entry is `world(joint) * inverse_bind()`.
    #[inline]
    #[must_use]
    pub fn inverse_bind(&self) -> Affine {
        Affine {
            columns: bytemuck::cast(self.inverse_bind),
        }
    }
}
