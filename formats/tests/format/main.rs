//! The file format: round trips, damage, and every rule that a file must keep.

#[path = "../fixture/mod.rs"]
mod fixture;

mod bare_boxes;
mod bare_key_boxes;
mod bare_node_movers;
mod bare_pose_spaces;
mod bare_reader;
mod bare_wide_trees;
mod broken;
mod cache_limits;
mod cache_rules;
mod damage;
mod golden;
mod header_fields;
mod messages;
mod pose_space_limits;
mod pose_space_rules;
mod random_bytes;
mod round_trip;
mod row_rules;
mod section_fields;
mod wide_rules;
