//! Other projects over the same posed vertices. `PEERS.md` beside this crate's manifest says what they are.
//!
//! Their frames begin as ours do: poses are set. Then all vertices are posed, their tree is refitted or built anew, and rays are
//! traced, which they get in their own form before the frame begins.

mod embree;
mod obvhs;
mod skinned;
mod skinning;
mod tinybvh;

use super::{contestants::Named, crowd::Crowd, settings::FrameSettings};
use crate::{
    MeasureError,
    embree::{Device, Quality, Update},
};
use skinned::{Skinned, Structure};
use skinning::Skinning;
use std::sync::Arc;

/// A peer's strategy.
pub(super) struct Peer {
    /// `who-strategy`.
    pub name: &'static str,
    /// Makes nothing of a single instance.
    crowds_only: bool,
    make: fn(&Inputs) -> Box<dyn Structure>,
}

/// What structures are made of.
struct Inputs<'a> {
    device: &'a Arc<Device>,
    /// Corners of one instance.
    triangles: Vec<[u32; 3]>,
    /// Vertices of one instance.
    vertex_count: usize,
    instances: usize,
}

const fn peer(name: &'static str, make: fn(&Inputs) -> Box<dyn Structure>) -> Peer {
    Peer {
        name,
        crowds_only: false,
        make,
    }
}

/// All peers, a line each.
pub(super) const PEERS: &[Peer] = &[
    peer("embree-refit", |inputs| embree::flat(inputs, Update::Refit)),
    peer("embree-low", |inputs| {
        embree::flat(inputs, Update::Rebuild(Quality::Low))
    }),
    peer("embree-medium", |inputs| {
        embree::flat(inputs, Update::Rebuild(Quality::Medium))
    }),
    Peer {
        crowds_only: true,
        ..peer("embree-instances", embree::instances)
    },
    peer("tinybvh-refit", |inputs| tinybvh::structure(inputs, true)),
    peer("tinybvh-rebuild", |inputs| tinybvh::structure(inputs, false)),
    Peer {
        crowds_only: true,
        ..peer("tinybvh-instances", tinybvh::instances)
    },
    peer("obvhs-refit", |inputs| obvhs::structure(inputs, true)),
    peer("obvhs-rebuild", |inputs| obvhs::structure(inputs, false)),
];

/// Those that are chosen, with so many threads.
pub(super) fn contestants(
    crowd: &Arc<Crowd>,
    settings: &FrameSettings,
    threads: usize,
) -> Result<Vec<Named>, MeasureError> {
    let chosen = |peer: &&Peer| settings.chosen(peer.name) && !(peer.crowds_only && crowd.transforms.len() == 1);
    let peers: Vec<&Peer> = PEERS.iter().filter(chosen).collect();
    if peers.is_empty() {
        return Ok(Vec::new());
    }
    let device = Device::new(threads).ok_or_else(|| MeasureError::peer("Embree", "it gives no device"))?;
    let model = crowd.asset.model();
    let inputs = Inputs {
        device: &Arc::new(device),
        triangles: model.triangles.iter().map(|row| row.corners).collect(),
        vertex_count: model.vertices.len() - 1,
        instances: crowd.transforms.len(),
    };
    let skinning = Arc::new(Skinning::new(crowd)?);
    let contestant = |peer: &Peer| Named {
        name: peer.name,
        contestant: Box::new(Skinned::new(&skinning, (peer.make)(&inputs))),
    };
    Ok(peers.into_iter().map(contestant).collect())
}

impl Inputs<'_> {
    /// Corners of all instances, whose vertices come one after the other.
    fn all_triangles(&self) -> Vec<[u32; 3]> {
        let shifted = |instance: usize| {
            let first = (instance * self.vertex_count) as u32;
            self.triangles
                .iter()
                .map(move |corners| corners.map(|corner| corner + first))
        };
        (0..self.instances).flat_map(shifted).collect()
    }

    fn all_vertices(&self) -> Vec<[f32; 4]> {
        vec![[0.0; 4]; self.vertex_count * self.instances]
    }
}
