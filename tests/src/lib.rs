//! What the cross-crate tests share: where scenes are, and references to compare with.

pub mod cache_reference;
mod dyadic;
pub mod escapes;
pub mod gltf_reference;
mod random_animation;
mod random_cache;
mod scenes;

pub use dyadic::Dyadic;
pub use random_animation::{Recipe, random_animation};
pub use random_cache::{CacheRecipe, Motion, random_cache};
pub use scenes::{baked_asset, baked_with, sample_scenes, source_scenes};
