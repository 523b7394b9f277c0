//! Readers of source files. Each gives an [`Animation`] or every fault it found.

mod animation;
mod fault;

pub use animation::{
    Animation, Channel, ChannelTarget, Clip, Influence, Local, Mesh, Node, Part, Primitive, Skin,
};
pub use fault::{Fault, ImportError, Severity};
