//! What is imported is what the source says: vertices, surfaces, clips, vertex caches, morph targets.

mod cache_contract;
mod cache_sources;
mod gltf_crate;
mod morph_caches;
mod odd_sources;
mod selection;
mod source_vertices;
mod surfaces;
