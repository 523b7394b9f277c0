//! What the cross-crate tests share: where scenes are, and references to compare with.

mod aimed_rays;
pub mod cache_reference;
mod cached_mesh;
mod closed_surfaces;
mod dyadic;
pub mod escapes;
pub mod followed_nodes;
mod following_twin;
pub mod gltf_reference;
pub mod inside;
mod jointed_mesh;
mod kd_twin;
pub mod key_box_escapes;
mod landmarks;
mod posed_planes;
mod random_animation;
mod random_cache;
mod scenes;
mod stage;
mod widened_tree;

pub use aimed_rays::{Aim, AimedRays, ODD_COMPONENTS};
pub use cached_mesh::cached_mesh;
pub use closed_surfaces::{beads, closed_surfaces, tube};
pub use dyadic::Dyadic;
pub use following_twin::following_twin;
pub use jointed_mesh::{MeshRecipe, jointed_mesh};
pub use kd_twin::kd_twin;
pub use landmarks::{Landmarks, LocalPlanes, wide_boxes};
pub use random_animation::{Recipe, random_animation};
pub use random_cache::{CacheRecipe, Motion, random_cache};
pub use scenes::{baked_animation, baked_asset, baked_with, sample_scenes, source_scenes};
pub use stage::{Stage, assert_rays_equal, hit_bits};
