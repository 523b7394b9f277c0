//! Import: a test for every row of `tools/IMPORT.md`, and for every kind of bad input.

mod accessors;
mod bad_caches;
mod bad_files;
mod bad_links;
mod bad_numbers;
mod bad_obj;
mod cache_builder;
mod cache_mutations;
mod caches;
mod clips;
mod containers;
mod extensions;
mod gltf_builder;
mod guarantee;
mod hostile;
mod inputs;
mod morphs;
mod mutations;
mod nodes;
mod obj_groups;
mod obj_meshes;
mod primitives;
mod scenes;
mod sequences;
mod skins;
mod table;
