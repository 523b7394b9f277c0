//! The rows of a file's sections: `#[repr(C)]`, little-endian, no padding, no pointers.
//!
//! Indices count rows of the section named in the field's text; [`NONE`] marks an absent index.

mod cache;
mod clip;
mod clip_bounds;
mod cluster;
mod envelope;
mod kd_node;
mod key_box;
mod morph;
mod node_mover;
mod part;
mod reference_box;
mod skeleton;
mod vertex;
mod wide_node;

pub use cache::{CacheRow, KeyRow, KeyVertexRow, SegmentRow, TrackRow};
pub use clip::{ChannelRow, ClipRow, Interpolation, Path, STRETCHES, SampleRow};
pub use clip_bounds::ClipBoundsRow;
pub use cluster::{ClusterBoneRow, ClusterRow};
pub use envelope::{BoneEnvelopeRow, ClusterMorphRow, LeverRow, MorphEnvelopeRow, PoseSpaceRow};
pub use kd_node::{KdNode, KdNodeRow, MAX_KD_DEPTH};
pub use key_box::KeyBoxRow;
pub use morph::{MorphDeltaRow, MorphSetRow, MorphTargetRow};
pub use node_mover::{MAX_MOVERS, MOVER_WEIGHTS, NodeMoverRow, RestLattice};
pub use part::{MotionClass, PartRow, PrimitiveRow};
pub use reference_box::{ReferenceBoxRow, box_steps};
pub use skeleton::{BoneRow, Local, NodeRow, ROOT_BONE};
pub use vertex::{InfluenceRow, TriangleRow, VertexRow, WEIGHT_STEP};
pub use wide_node::{MAX_WIDE_DEPTH, WideChild, WideNodeRow};

/// Marks an index that points nowhere.
pub const NONE: u32 = u32::MAX;
