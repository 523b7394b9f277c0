//! Import of glTF: one test per row of `tools/IMPORT.md`.

mod scenes;
