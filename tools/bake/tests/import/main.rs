//! Import of glTF: a test for every row of `tools/IMPORT.md`, and for every kind of bad input.

mod accessors;
mod bad_files;
mod bad_links;
mod bad_numbers;
mod clips;
mod containers;
mod extensions;
mod gltf_builder;
mod hostile;
mod morphs;
mod mutations;
mod nodes;
mod primitives;
mod scenes;
mod skins;
mod table;
