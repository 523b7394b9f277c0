//! Tests of the builders: what trees promise, over families of boxes.

mod borders;
mod families;
mod faults;
mod hand_cases;
mod invariants;
mod optimum;
mod queries;
mod random;
mod streamed_bvh;
