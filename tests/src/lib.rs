//! What the cross-crate tests share: where scenes are, and references to compare with.

pub mod gltf_reference;
mod scenes;

pub use scenes::{sample_scenes, source_scenes};
