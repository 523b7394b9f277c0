//! Tests of the kd-tree builder from outside: what a tree promises, over families of boxes.

mod families;
mod faults;
mod hand_cases;
mod invariants;
mod optimum;
mod queries;
mod random;
mod streamed_bvh;
