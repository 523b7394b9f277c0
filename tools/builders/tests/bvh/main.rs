//! Tests of all builders of bounding volume hierarchies: what a tree promises, and that each builder is what its paper
//! says.

mod builders;
mod depth;
mod determinism;
mod families;
mod medians;
mod optimum;
mod refit;
mod tree_sets;
mod validity;
mod wide;
