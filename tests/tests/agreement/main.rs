//! Hits equal brute force, bit for bit: poses, batches, threads, large trees, supplied triangles.

mod any_pose;
mod bundles;
mod contract;
mod far_trees;
mod lazy;
mod many_poses;
mod shattering_vase;
mod structure_choice;
mod supplied_geometry;
mod wholes_of_caches;
