//! What `vertex_memo` is made of: a test compiles that file with atomics that try every order in which threads may run.

pub(crate) use std::sync::atomic::{AtomicU32, Ordering};
