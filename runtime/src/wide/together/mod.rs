//! Coherent rays that go through trees together.
//!
//! A [`Packet`] makes bundles of rays that follow each other. [`walk_together`] takes one down a wide tree, in world space or, once
//! it has [entered](Bundled::in_cluster) a cluster, its [`FuzzyNodes`] in local space, as long as more than a few of its rays go
//! the same way; leaves and nodes below which few go on it leaves to its caller. Through kd-trees groups of eight go, each ray in a
//! lane of its own ([`Bundled::walk_kd`]).
//!
//! Based on: Wald et al., *Interactive Rendering with Coherent Ray Tracing*, 2001 (packets); Boulos, Wald and Shirley,
//! *Geometric and Arithmetic Culling Methods for Entire Ray Packets*, 2006 (interval arithmetic). Differs: a box is tested
//! against the bundles of all groups of eight rays at once, lane by lane, so that there is no first active ray to look for.

mod bundled;
#[cfg(test)]
mod cluster_tests;
mod fuzzy_nodes;
mod group_bundles;
mod kd_groups;
mod local_lattice;
mod packet;
mod ray_bundle;
mod ray_group;
#[cfg(test)]
mod tests;
mod walk;

pub(crate) use bundled::{Bundled, LocalRays};
pub(crate) use fuzzy_nodes::{FuzzyNodes, FuzzyPath};
pub(crate) use kd_groups::{KdSpace, KdStack};
pub(crate) use local_lattice::LocalLattice;
pub(crate) use packet::{PACKET, Packet};
pub(crate) use ray_group::{GROUP, GroupHits};
pub(crate) use walk::{Part, walk_together};
