//! The built program as a user meets it: help, messages, exit codes, output, files.

mod bad_caches;
mod bad_files;
mod bake;
mod command_line;
mod demo;
mod fixture;
mod flag;
mod help;
mod joint_limits;
mod json;
mod pictures;
mod pose_spaces;
mod run;
mod terminal;
mod tree_builders;
mod verification;
mod vertex_caches;
