//! Boxes, affine maps and directed rounding: the arithmetic that baked bounds and run-time margins share.

mod aabb;
mod affine;
pub mod round;

pub use aabb::Aabb;
pub use affine::Affine;
