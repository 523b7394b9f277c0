//! Small glTF scenes and vertex caches of our own making, each from formulas alone.
//!
//! Guarantee: the same bytes on every platform and in every build; sines come from `libm`, sums have a fixed order.

pub mod ball_flight;
pub mod column;
pub mod creature;
pub mod curve;
pub mod figure;
pub mod flat_mesh;
pub mod flower;
pub mod gait;
pub mod gltf_json;
pub mod gltf_writer;
pub mod goose;
pub mod goose_body;
pub mod goose_pose;
pub mod jelly;
pub mod limbs;
pub mod machine;
pub mod mixed;
pub mod obj_writer;
pub mod point_cache_writer;
pub mod polygons;
pub mod rotation;
pub mod shard_flight;
pub mod shatter;
pub mod skinning;
pub mod solids;
pub mod surface;
pub mod surface_net;
pub mod tentacle;
pub mod vase;
pub mod walker;

use gltf_writer::WriteError;
use point_cache_writer::CacheWriteError;

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// Name within `samples/scenes`.
    pub name: &'static str,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// Every file of `samples/scenes`, generated afresh.
///
/// # Errors
/// [`SceneError`] where a scene cannot be written.
pub fn scene_files() -> Result<Vec<SceneFile>, SceneError> {
    let (tentacle, tentacle_buffer) = tentacle::tentacle_gltf_and_bin("tentacle.bin")?;
    let (goose, goose_cache) = goose::goose_obj_and_pc2()?;
    let (shatter, shatter_cache) = shatter::shatter_obj_and_pc2()?;
    let file = |name, bytes| SceneFile { name, bytes };
    Ok(vec![
        file("walker.glb", walker::walker_glb()?),
        file("tentacle.gltf", tentacle),
        file("tentacle.bin", tentacle_buffer),
        file("machine.gltf", machine::machine_gltf()?),
        file("mixed.glb", mixed::mixed_glb()?),
        file("goose.obj", goose),
        file("goose.pc2", goose_cache),
        file("shatter.obj", shatter),
        file("shatter.pc2", shatter_cache),
    ])
}

/// Why a scene could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// As glTF.
    #[error(transparent)]
    Gltf(#[from] WriteError),
    /// As a vertex cache.
    #[error(transparent)]
    Cache(#[from] CacheWriteError),
}
