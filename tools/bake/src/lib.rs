//! The bake: import, classify, decompose, bound, build, write. Each stage is a library function with its settings;
//! none prints, exits or keeps state between calls.

pub mod import;
