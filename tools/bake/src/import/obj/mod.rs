//! Wavefront OBJ: points and faces; all else is skipped.
//!
//! Read with our own code instead of the `tobj` crate (looked at: 4.0). That crate renumbers the points of each group in
//! order of first use and does not say which they were, so that no vertex cache could move them; its errors have no
//! line numbers; and it panics on a corner such as `1/1/1/-1`.
//!
//! Stages: lines → statements ([`reader`]) → [`mesh`] → [`parts`].

mod lines;
pub(super) mod mesh;
pub(super) mod parts;
pub(super) mod reader;
