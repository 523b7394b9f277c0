//! Wide trees: nodes of eight children whose boxes one ray meets in one step.
//!
//! One traversal, [`Descent`], serves both kinds of node: [`WideNode`]s with boxes in world space (the top level, an
//! instance's top level, trees over posed triangles), and the rows of a file, whose boxes are on one of their cluster's
//! two lattices in its local space ([`FuzzyRay`]), for all poses, for what moves in this one, or between two keys
//! ([`KeyBoxes`]). [`refit`] gives a tree the boxes of this frame, [`append_rows`] takes the topology of a file's
//! tree, [`collapse`] makes a wide tree of a binary one.
//!
//! Coherent rays go through trees in world space together: a [`Packet`] makes a bundle of them, which [`walk_together`] takes
//! down a tree as long as more than a few of them go the same way; leaves and nodes below which few go on it leaves to its
//! caller.
//!
//! Based on: Wald et al., *Interactive Rendering with Coherent Ray Tracing*, 2001 (packets); Boulos, Wald and Shirley,
//! *Geometric and Arithmetic Culling Methods for Entire Ray Packets*, 2006 (interval arithmetic). Differs: a box is tested
//! against the bundles of all groups of eight rays at once, lane by lane, so that there is no first active ray to look for.

mod boxes;
mod bundle;
mod collapse;
mod descent;
mod fuzzy_nodes;
mod fuzzy_ray;
#[cfg(test)]
mod fuzzy_ray_tests;
mod group_bundles;
mod kd_groups;
mod key_boxes;
mod local_lattice;
mod node;
mod packet;
#[cfg(test)]
mod packet_tests;
mod packet_walk;
mod ray;
mod ray_group;
mod refit;
mod stack;
#[cfg(test)]
mod tests;

pub(crate) use boxes::WideBoxes;
pub(crate) use collapse::collapse;
pub(crate) use descent::Descent;
pub(crate) use fuzzy_nodes::{FuzzyNodes, FuzzyPath};
pub(crate) use fuzzy_ray::{FuzzyBoxes, FuzzyRay};
pub(crate) use kd_groups::{KdSpace, KdStack};
pub(crate) use key_boxes::KeyBoxes;
pub(crate) use local_lattice::LocalLattice;
pub(crate) use node::{WideNode, append_rows};
pub(crate) use packet::{Bundled, LocalRays, PACKET, Packet};
pub(crate) use packet_walk::{Part, walk_together};
pub(crate) use ray::WideRay;
pub(crate) use ray_group::{GROUP, GroupHits};
pub(crate) use refit::{refit, refit_triangles};
pub(crate) use stack::{DEPTHS, WideStack};
