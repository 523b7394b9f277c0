//! Tests of the builders of kd-trees: what a tree promises, its cost, and its bytes.

mod families;
mod streamed;
mod tracked;
