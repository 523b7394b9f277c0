//! Wide trees: nodes of eight children whose boxes one ray meets in one step.
//!
//! One traversal, [`walk`], serves both kinds of node: [`WideNode`]s with boxes in world space (the top level, an
//! instance's top level, trees over posed triangles), and the rows of a file, whose boxes are on their cluster's lattice
//! in its local space. [`refit`] gives a tree the boxes of this frame, [`append_rows`] takes the topology of a file's
//! tree, [`collapse`] makes a wide tree of a binary one.

mod boxes;
mod collapse;
mod node;
mod ray;
mod refit;
mod stack;
#[cfg(test)]
mod tests;
mod walk;

pub(crate) use collapse::collapse;
pub(crate) use node::{WideNode, append_rows};
pub(crate) use ray::WideRay;
pub(crate) use refit::refit;
pub(crate) use stack::WideStack;
pub(crate) use walk::{Limited, walk};
