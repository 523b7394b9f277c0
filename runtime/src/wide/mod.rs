//! Wide trees: nodes of eight children whose boxes one ray meets in one step.
//!
//! One traversal, [`Descent`], serves both kinds of node: [`WideNode`]s with boxes in world space (the top level, an
//! instance's top level, trees over posed triangles), and the rows of a file, whose boxes are on one of their cluster's
//! two lattices in its local space ([`FuzzyRay`]), for all poses, for what moves in this one, or between two keys
//! ([`KeyBoxes`]). [`refit`] gives a tree the boxes of this frame, [`append_rows`] takes the topology of a file's
//! tree, [`collapse`] makes a wide tree of a binary one.
//!
//! Coherent rays go through trees [`together`].

mod boxes;
mod collapse;
mod descent;
mod fuzzy_ray;
#[cfg(test)]
mod fuzzy_ray_tests;
mod key_boxes;
mod node;
mod ray;
mod refit;
mod stack;
#[cfg(test)]
mod tests;
mod together;

pub(crate) use boxes::WideBoxes;
pub(crate) use collapse::collapse;
pub(crate) use descent::Descent;
pub(crate) use fuzzy_ray::{FuzzyBoxes, FuzzyRay};
pub(crate) use key_boxes::KeyBoxes;
pub(crate) use node::{WideNode, append_nodes, append_rows};
pub(crate) use ray::WideRay;
pub(crate) use refit::{refit, refit_triangles};
pub(crate) use stack::{DEPTHS, WideStack};
pub(crate) use together::{
    Bundled, FuzzyNodes, FuzzyPath, GROUP, GroupHits, KdSpace, KdStack, LocalLattice, LocalRays, PACKET, Packet, Part,
    walk_together,
};
