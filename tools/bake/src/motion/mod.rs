//! How parts move: their class, and for skinned ones the bone that carries each triangle.

mod classify;
mod decompose;
pub(crate) mod keyframed;
mod morph_cache;
mod moving;

pub(crate) use classify::{Classified, classify};
pub(crate) use decompose::{Carried, decompose};
pub(crate) use morph_cache::{turned, with_morph_caches};
pub(crate) use moving::{Moving, parents_first};
